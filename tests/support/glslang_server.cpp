// Compiles many texts in one process: glslang's own start takes 90 ms for each text otherwise.
//
// A request is three u32 (stage as EShLanguage, length, 0) and the text; an answer is the number of
// words, 0 if the text is refused, and the words of its SPIR-V. Settings are those of
// `glslangValidator -V --aml --amb`.
#include <cstdint>
#include <cstdio>
#include <string>
#include <unistd.h>
#include <vector>

#include <glslang/Public/ResourceLimits.h>
#include <glslang/Public/ShaderLang.h>
#include <glslang/SPIRV/GlslangToSpv.h>

static std::vector<unsigned int> compile(EShLanguage stage, const std::string& text) {
    const auto messages = static_cast<EShMessages>(EShMsgSpvRules | EShMsgVulkanRules);
    glslang::TShader shader(stage);
    const char* strings[] = {text.data()};
    const int lengths[] = {static_cast<int>(text.size())};
    shader.setStringsWithLengths(strings, lengths, 1);
    shader.setEnvInput(glslang::EShSourceGlsl, stage, glslang::EShClientVulkan, 100);
    shader.setEnvClient(glslang::EShClientVulkan, glslang::EShTargetVulkan_1_0);
    shader.setEnvTarget(glslang::EShTargetSpv, glslang::EShTargetSpv_1_0);
    shader.setAutoMapBindings(true);
    shader.setAutoMapLocations(true);
    if (!shader.parse(GetDefaultResources(), 100, false, messages)) return {};
    glslang::TProgram program;
    program.addShader(&shader);
    if (!program.link(messages) || !program.mapIO()) return {};
    std::vector<unsigned int> words;
    glslang::SpvOptions options;
    options.disableOptimizer = true;
    glslang::GlslangToSpv(*program.getIntermediate(stage), words, &options);
    return words;
}

int main() {
    glslang::InitializeProcess();
    // glslang prints some of its messages to stdout.
    FILE* answers = fdopen(dup(1), "wb");
    dup2(2, 1);
    uint32_t head[3];
    while (std::fread(head, sizeof head, 1, stdin) == 1) {
        std::string text(head[1], '\0');
        if (head[1] > 0 && std::fread(&text[0], head[1], 1, stdin) != 1) return 1;
        const auto words = compile(static_cast<EShLanguage>(head[0]), text);
        const auto count = static_cast<uint32_t>(words.size());
        std::fwrite(&count, sizeof count, 1, answers);
        std::fwrite(words.data(), sizeof(uint32_t), words.size(), answers);
        std::fflush(answers);
    }
    glslang::FinalizeProcess();
    return 0;
}
