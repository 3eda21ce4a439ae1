// Compiles many texts in one process: glslang's own start takes 90 ms for each text otherwise.
//
// A request is three u32 (stage as EShLanguage, length, 1 for OpenGL) and the text; an answer is the
// number of words, 0 if the text is refused, the words of its SPIR-V, and the length and the text of
// the log. Settings are those of `glslangValidator -V --aml --amb`; for OpenGL those without options,
// and a single word stands for SPIR-V, which is not made.
#include <cstdint>
#include <cstdio>
#include <string>
#include <unistd.h>
#include <vector>

#include <glslang/Public/ResourceLimits.h>
#include <glslang/Public/ShaderLang.h>
#include <glslang/SPIRV/GlslangToSpv.h>

static std::vector<unsigned int> opengl(EShLanguage stage, const std::string& text,
                                        std::string& log) {
    glslang::TShader shader(stage);
    const char* strings[] = {text.data()};
    const int lengths[] = {static_cast<int>(text.size())};
    shader.setStringsWithLengths(strings, lengths, 1);
    bool taken = shader.parse(GetDefaultResources(), 110, false, EShMsgDefault);
    log = shader.getInfoLog();
    if (!taken) return {};
    glslang::TProgram program;
    program.addShader(&shader);
    taken = program.link(EShMsgDefault);
    log += program.getInfoLog();
    return taken ? std::vector<unsigned int>{1} : std::vector<unsigned int>{};
}

static std::vector<unsigned int> compile(EShLanguage stage, const std::string& text,
                                         std::string& log) {
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
    const bool parsed = shader.parse(GetDefaultResources(), 100, false, messages);
    log = shader.getInfoLog();
    if (!parsed) return {};
    glslang::TProgram program;
    program.addShader(&shader);
    const bool linked = program.link(messages) && program.mapIO();
    log += program.getInfoLog();
    if (!linked) return {};
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
        std::string log;
        const auto stage = static_cast<EShLanguage>(head[0]);
        const auto words = head[2] == 1 ? opengl(stage, text, log) : compile(stage, text, log);
        const auto count = static_cast<uint32_t>(words.size());
        std::fwrite(&count, sizeof count, 1, answers);
        std::fwrite(words.data(), sizeof(uint32_t), words.size(), answers);
        const auto length = static_cast<uint32_t>(log.size());
        std::fwrite(&length, sizeof length, 1, answers);
        std::fwrite(log.data(), 1, log.size(), answers);
        std::fflush(answers);
    }
    glslang::FinalizeProcess();
    return 0;
}
