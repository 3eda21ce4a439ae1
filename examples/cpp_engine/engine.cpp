// A small engine that sets members of uniform blocks by name. It keeps no
// table of offsets: names and places come from the generated header, so a
// shader that changes cannot leave them behind. It prints the bytes of its
// blocks, one after the other.

#include "lights.h"

#include <cstdio>
#include <cstring>
#include <string>
#include <type_traits>
#include <unordered_map>
#include <vector>

struct Vec3 {
    float x, y, z;
};

// The buffers behind the block instances of a program.
class UniformBuffers {
public:
    using Lookup = int64_t (*)(const char *path, const landfall_leaf **found);

    void Register(const std::string &instance, std::size_t size, Lookup lookup) {
        blocks_[instance] = Block{std::vector<unsigned char>(size), lookup};
    }

    // Sets one member: UpdateSubData("u_point_lights", "data[3].color", red).
    // False when there is no such member, or it is of another size.
    template <typename T>
    bool UpdateSubData(const std::string &instance, const std::string &path, const T &value) {
        static_assert(std::is_trivially_copyable<T>::value, "values are uploaded as bytes");
        const auto block = blocks_.find(instance);
        if (block == blocks_.end()) {
            return false;
        }
        const landfall_leaf *leaf = nullptr;
        const int64_t offset = block->second.lookup(path.c_str(), &leaf);
        if (offset < 0 || leaf->size != sizeof(T)) {
            return false;
        }
        // With OpenGL: glBufferSubData(GL_UNIFORM_BUFFER, offset, sizeof(T), &value).
        std::memcpy(block->second.bytes.data() + offset, &value, sizeof(T));
        return true;
    }

    const std::vector<unsigned char> &Bytes(const std::string &instance) const {
        return blocks_.at(instance).bytes;
    }

private:
    struct Block {
        std::vector<unsigned char> bytes;
        Lookup lookup;
    };
    std::unordered_map<std::string, Block> blocks_;
};

// One slot of the point lights.
class Lamp {
public:
    Lamp(UniformBuffers &buffers, unsigned slot) : buffers_(buffers), slot_(slot) {}

    template <typename T>
    bool Set(const std::string &member, const T &value) {
        const std::string path = "data[" + std::to_string(slot_) + "]." + member;
        return buffers_.UpdateSubData("u_point_lights", path, value);
    }

private:
    UniformBuffers &buffers_;
    unsigned slot_;
};

int main() {
    UniformBuffers buffers;
    buffers.Register("u_ambient", AMBIENT_BLOCK_SIZE, ambient_block_lookup);
    buffers.Register("u_directional_lights", DIRECTIONAL_LIGHT_BLOCK_SIZE,
                     directional_light_block_lookup);
    buffers.Register("u_point_lights", POINT_LIGHT_BLOCK_SIZE, point_light_block_lookup);

    bool good = buffers.UpdateSubData("u_ambient", "color", Vec3{1, 1, 1});
    good &= buffers.UpdateSubData("u_ambient", "intensity", 0.25f);
    good &= buffers.UpdateSubData("u_directional_lights", "data[0].dir", Vec3{0, -1, 0});
    good &= buffers.UpdateSubData("u_directional_lights", "actually_used_count", int32_t{1});

    Lamp red(buffers, 0);
    good &= red.Set("pos", Vec3{-2, 0, 5}) && red.Set("color", Vec3{1, 0, 0});
    Lamp green(buffers, 1);
    good &= green.Set("pos", Vec3{2, 0, 5}) && green.Set("color", Vec3{0, 1, 0});
    good &= green.Set("intensity", 3.0f) && green.Set("constant", 1.0f);
    good &= green.Set("linear", 0.35f) && green.Set("quadratic", 0.44f);
    good &= buffers.UpdateSubData("u_point_lights", "actually_used_count", int32_t{2});

    // What a table written by hand lets pass in silence.
    bool refused = !green.Set("colour", Vec3{0, 1, 0});
    refused &= !green.Set("color", 1.0f);
    refused &= !Lamp(buffers, POINT_LIGHT_BLOCK_DATA_COUNT).Set("color", Vec3{0, 1, 0});
    refused &= !buffers.UpdateSubData("u_spot_lights", "data[0].pos", Vec3{0, 0, 0});

    // The same bytes through the structure: no names, no offsets.
    PointLightBlock whole;
    std::memcpy(&whole, buffers.Bytes("u_point_lights").data(), sizeof(whole));
    good &= whole.data[1].intensity == 3.0f && whole.actually_used_count == 2;

    for (const char *instance : {"u_ambient", "u_directional_lights", "u_point_lights"}) {
        const auto &bytes = buffers.Bytes(instance);
        std::fwrite(bytes.data(), 1, bytes.size(), stdout);
    }
    return good && refused ? 0 : 1;
}
