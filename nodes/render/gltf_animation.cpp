#include "render/gltf_animation.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "graph/diagnostic.h"

namespace weft {
namespace {

Affine rotation_of(const float* q) {
    const float x = q[0], y = q[1], z = q[2], w = q[3];
    return {{1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)},
            {2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)},
            {2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)},
            {}};
}

bool normalize(float* q) {
    const float size = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(size > 1e-12f) || !std::isfinite(size)) return false;
    for (int i = 0; i < 4; ++i) q[i] /= size;
    return true;
}

std::string node_name(const tinygltf::Model& model, size_t i) {
    const std::string& name = model.nodes[i].name;
    return name.empty() ? fmt::format("node {}", i) : fmt::format("node {} ('{}')", i, name);
}

void read_numbers(const GltfFile& file, const std::vector<double>& from, float* to, size_t count,
                  const std::string& what) {
    if (from.empty()) return;
    if (from.size() != count)
        file.fail(what, fmt::format("{} numbers; expected {}", from.size(), count));
    for (size_t i = 0; i < count; ++i) {
        to[i] = float(from[i]);
        if (!std::isfinite(to[i])) file.fail(what, "not finite");
    }
}

}  // namespace

Affine GltfPose::local() const {
    if (has_matrix) return matrix;
    Affine m = rotation_of(rotation) * weft::scale(scale);
    m.origin = translation;
    return m;
}

GltfPoses::GltfPoses(const GltfFile& file, const std::string& animation) {
    const auto& model = file.model();
    for (size_t i = 0; i < model.nodes.size(); ++i) {
        const auto& node = model.nodes[i];
        GltfPose pose;
        float m[16] = {};
        read_numbers(file, node.matrix, m, 16, node_name(model, i) + ", matrix");
        pose.has_matrix = !node.matrix.empty();
        pose.matrix = {
            {m[0], m[1], m[2]}, {m[4], m[5], m[6]}, {m[8], m[9], m[10]}, {m[12], m[13], m[14]}};
        float t[3] = {}, s[3] = {1, 1, 1};
        read_numbers(file, node.translation, t, 3, node_name(model, i) + ", translation");
        read_numbers(file, node.scale, s, 3, node_name(model, i) + ", scale");
        read_numbers(file, node.rotation, pose.rotation, 4, node_name(model, i) + ", rotation");
        if (!normalize(pose.rotation)) file.fail(node_name(model, i), "its rotation is zero");
        pose.translation = {t[0], t[1], t[2]}, pose.scale = {s[0], s[1], s[2]};
        const std::vector<double>* weights = &node.weights;
        if (weights->empty() && node.mesh >= 0 && size_t(node.mesh) < model.meshes.size())
            weights = &model.meshes[size_t(node.mesh)].weights;
        for (const double w : *weights) pose.weights.push_back(std::isfinite(w) ? float(w) : 0.0f);
        rest_.push_back(std::move(pose));
    }
    of_node_.resize(model.nodes.size());
    if (animation.empty()) {
        for (size_t i = 0; i < model.animations.size(); ++i) add(file, i);
        return;
    }
    std::vector<std::string> names;
    for (size_t i = 0; i < model.animations.size(); ++i) {
        names.push_back(model.animations[i].name);
        if (names.back() == animation) {
            add(file, i);
            return;
        }
    }
    size_t number = 0;
    const auto [end, error] =
        std::from_chars(animation.data(), animation.data() + animation.size(), number);
    if (error == std::errc() && end == animation.data() + animation.size() &&
        number < names.size()) {
        add(file, number);
        return;
    }
    file.fail(fmt::format("animation '{}'", animation),
              fmt::format("it has no such animation{}",
                          names.empty() ? ", nor any other" : suggestion(animation, names)));
}

void GltfPoses::add(const GltfFile& file, size_t number) {
    const auto& model = file.model();
    const auto& animation = model.animations[number];
    for (size_t c = 0; c < animation.channels.size(); ++c) {
        const auto& channel = animation.channels[c];
        const std::string what = fmt::format("animation {}, channel {}", number, c);
        if (channel.target_node < 0) continue;
        Track track;
        track.node = file.index(channel.target_node, model.nodes.size(), what, "node");
        using Path = Track::Path;
        if (channel.target_path == "translation")
            track.path = Path::translation, track.width = 3;
        else if (channel.target_path == "rotation")
            track.path = Path::rotation, track.width = 4;
        else if (channel.target_path == "scale")
            track.path = Path::scale, track.width = 3;
        else if (channel.target_path == "weights")
            track.path = Path::weights, track.width = 0;
        else
            continue;  // an extension's
        const bool taken =
            std::any_of(of_node_[track.node].begin(), of_node_[track.node].end(),
                        [&](size_t other) { return tracks_[other].path == track.path; });
        if (taken) continue;
        const auto& sampler =
            animation
                .samplers[file.index(channel.sampler, animation.samplers.size(), what, "sampler")];
        using Interpolation = Track::Interpolation;
        track.interpolation = sampler.interpolation == "STEP"          ? Interpolation::step
                              : sampler.interpolation == "CUBICSPLINE" ? Interpolation::cubic
                                                                       : Interpolation::linear;
        track.times = file.numbers(sampler.input, 1, what);
        track.values =
            file.numbers(sampler.output, track.path == Path::weights ? 1 : int(track.width), what);
        if (track.times.empty()) file.fail(what, "it has no keys");
        for (size_t i = 1; i < track.times.size(); ++i)
            if (!(track.times[i] > track.times[i - 1]))
                file.fail(what, fmt::format("key {} is not later than the one before", i));
        const size_t each = track.interpolation == Interpolation::cubic ? 3 : 1;
        if (track.path == Path::weights)
            track.width = track.values.size() / (each * track.times.size());
        if (track.width == 0 || track.values.size() != each * track.width * track.times.size())
            file.fail(what, fmt::format("{} keys and {} numbers do not match", track.times.size(),
                                        track.values.size()));
        of_node_[track.node].push_back(tracks_.size());
        tracks_.push_back(std::move(track));
    }
}

void GltfPoses::sample(const Track& track, float seconds, std::vector<float>& out) {
    const size_t n = track.width, keys = track.times.size();
    const bool cubic = track.interpolation == Track::Interpolation::cubic;
    const auto key = [&](size_t i, size_t part) {
        return track.values.data() + (cubic ? 3 * i + part : i) * n;
    };
    const auto value = [&](size_t i) { return key(i, 1); };
    out.resize(n);
    const auto next = std::upper_bound(track.times.begin(), track.times.end(), seconds);
    const auto b = size_t(next - track.times.begin());
    if (b == 0 || b == keys || track.interpolation == Track::Interpolation::step) {
        const float* v = value(b == 0 ? 0 : b - 1);
        std::copy(v, v + n, out.begin());
        return;
    }
    const size_t a = b - 1;
    const float span = track.times[b] - track.times[a], s = (seconds - track.times[a]) / span;
    const float *p = value(a), *q = value(b);
    if (cubic) {
        const float s2 = s * s, s3 = s2 * s;
        const float *leave = key(a, 2), *arrive = key(b, 0);
        for (size_t i = 0; i < n; ++i)
            out[i] = (2 * s3 - 3 * s2 + 1) * p[i] + span * (s3 - 2 * s2 + s) * leave[i] +
                     (3 * s2 - 2 * s3) * q[i] + span * (s3 - s2) * arrive[i];
        return;
    }
    float weight_p = 1 - s, weight_q = s;
    if (track.path == Track::Path::rotation) {
        // Spherical, the short way round.
        float dot = p[0] * q[0] + p[1] * q[1] + p[2] * q[2] + p[3] * q[3];
        const float sign = dot < 0 ? -1.0f : 1.0f;
        dot = std::min(std::fabs(dot), 1.0f);
        const float angle = std::acos(dot), sine = std::sin(angle);
        if (sine > 1e-4f)
            weight_p = std::sin((1 - s) * angle) / sine, weight_q = std::sin(s * angle) / sine;
        weight_q *= sign;
    }
    for (size_t i = 0; i < n; ++i) out[i] = weight_p * p[i] + weight_q * q[i];
}

GltfPose GltfPoses::at(size_t node, float seconds) const {
    GltfPose pose = rest_[node];
    std::vector<float> v;
    for (const size_t t : of_node_[node]) {
        const Track& track = tracks_[t];
        sample(track, seconds, v);
        switch (track.path) {
            case Track::Path::translation:
                pose.translation = {v[0], v[1], v[2]};
                break;
            case Track::Path::scale:
                pose.scale = {v[0], v[1], v[2]};
                break;
            case Track::Path::rotation:
                if (normalize(v.data())) std::copy(v.begin(), v.end(), pose.rotation);
                break;
            case Track::Path::weights:
                pose.weights = v;
                break;
        }
        if (track.path != Track::Path::weights) pose.has_matrix = false;
    }
    return pose;
}

}  // namespace weft
