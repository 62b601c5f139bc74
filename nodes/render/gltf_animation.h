// GltfPoses: where every node of a glTF document stands at a time of its animations.
#pragma once
#include <string>
#include <vector>

#include "render/gltf_file.h"

namespace weft {

// A node's own place, and how far its mesh's shapes are morphed.
struct GltfPose {
    Vec3 translation{}, scale{1, 1, 1};
    float rotation[4] = {0, 0, 0, 1};  // x y z w
    bool has_matrix = false;
    Affine matrix;
    std::vector<float> weights;

    Affine local() const;
};

class GltfPoses {
  public:
    // `animation`: one by name or number, "" for all (of two that move the same thing, the first).
    GltfPoses(const GltfFile& file, const std::string& animation);

    bool animated() const { return !tracks_.empty(); }
    GltfPose at(size_t node, float seconds) const;

  private:
    struct Track {
        size_t node;
        enum class Path { translation, rotation, scale, weights } path;
        enum class Interpolation { step, linear, cubic } interpolation;
        std::vector<float> times, values;
        size_t width;  // numbers a key
    };
    static void sample(const Track& track, float seconds, std::vector<float>& out);
    void add(const GltfFile& file, size_t animation);

    std::vector<GltfPose> rest_;
    std::vector<Track> tracks_;
    std::vector<std::vector<size_t>> of_node_;
};

}  // namespace weft
