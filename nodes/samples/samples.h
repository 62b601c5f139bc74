// Samples: a renderer's sample buffer, a struct of arrays. Names, shapes and units are those of the
// native file (docs/formats.md): pixel (i, j) covers [i, i+1) x [j, j+1), y down; samples of a
// pixel lie together, pixels row by row from the top left.
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "graph/json.h"
#include "runtime/value.h"

namespace weft {

// An immutable array that somebody owns: a vector, or a mapped file.
template <class T>
class Array {
  public:
    Array() = default;
    Array(std::vector<T> values) {
        auto owned = std::make_shared<const std::vector<T>>(std::move(values));
        view_ = *owned;
        owner_ = std::move(owned);
    }
    Array(std::span<const T> view, std::shared_ptr<const void> owner)
        : view_(view), owner_(std::move(owner)) {}

    std::span<const T> view() const { return view_; }
    size_t size() const { return view_.size(); }
    bool empty() const { return view_.empty(); }
    const T& operator[](size_t i) const { return view_[i]; }

  private:
    std::span<const T> view_;
    std::shared_ptr<const void> owner_;
};

// The circle-of-confusion radius of a point at camera depth z is c0 / z + c1 pixels, signed: the
// slope of its trajectory over the lens, x(u) = x(0) + u (c0 / z + c1), y(v) likewise.
struct Lens {
    float c0 = 0, c1 = 0;
    float aspect = 1;    // anamorphic squeeze: slope in x over slope in y
    int blades = 0;      // 0: round
    float rotation = 0;  // of the blades, radians
    bool pinhole() const { return c0 == 0 && c1 == 0; }
    bool operator==(const Lens&) const = default;
};

// What part a channel takes in filters that ask (docs/formats.md).
enum class Role { none, position, random, feature, radiance };
std::string_view name_of(Role role);
// A standard channel's role: uv, t, light_uv, bounce are random; rgb, direct ... radiance; and so
// on.
Role standard_role(std::string_view channel);
bool is_standard_channel(std::string_view channel);
int standard_components(std::string_view channel);  // 0: any number, or not a standard name

struct Channel {
    std::string name;    // snake_case
    int components = 1;  // values a sample
    Role role = Role::none;
    Array<float> values;       // size() * components, sample by sample
    Array<std::uint32_t> ids;  // instead of values, for whole-number channels (id, light_index)
    bool whole() const { return !ids.empty(); }
};

class Samples {
  public:
    int width = 0, height = 0;
    int spp = 0;                 // samples in every pixel; 0: they vary, see `first`
    Array<std::uint64_t> first;  // pixels + 1 offsets; empty where spp is constant
    std::string color_space = "lin_rec709";
    std::string domain = "camera";  // or "light": no pixel order
    std::optional<Lens> lens;       // none: a pinhole
    Json meta;                      // the whole meta object, unknown keys included
    std::vector<Channel> channels;

    size_t size() const { return size_; }
    size_t pixels() const { return size_t(width) * size_t(height); }
    void set_size(size_t samples) { size_ = samples; }

    // The samples of a pixel: [begin, end).
    struct Range {
        size_t begin, end;
    };
    Range of_pixel(size_t pixel) const {
        if (spp > 0) return {pixel * size_t(spp), (pixel + 1) * size_t(spp)};
        return {size_t(first[pixel]), size_t(first[pixel + 1])};
    }
    double mean_spp() const { return pixels() ? double(size_) / double(pixels()) : 0; }

    const Channel* find(std::string_view channel) const;
    // Values of a channel, or an empty span where the buffer has none.
    std::span<const float> values(std::string_view channel) const;
    std::span<const float> xy() const { return values("xy"); }          // N x 2, pixels
    std::span<const float> uv() const { return values("uv"); }          // N x 2, unit disk
    std::span<const float> t() const { return values("t"); }            // N, [0, 1]
    std::span<const float> z() const { return values("z"); }            // N, > 0, +inf: background
    std::span<const float> motion() const { return values("motion"); }  // N x 3, homogeneous
    std::span<const float> rgb() const { return values("rgb"); }        // N x 3, scene-linear

    bool has_lens() const { return lens && !lens->pinhole() && !uv().empty(); }
    bool has_motion() const { return !t().empty() && !motion().empty(); }

    void add(Channel channel);  // replaces one of the same name
    void add(std::string name, int components,
             std::vector<float> values);  // with its standard role
    void add_ids(std::string name, std::vector<std::uint32_t> ids);

    // Brings `meta` up to date with the fields above (size, spp, lens, roles ...) and returns it.
    Json meta_object() const;

    // Throws Error naming what is missing, e.g. require("reproject", {"xy", "z"}): "'reproject'
    // needs z, this buffer has xy, rgb; ...".
    void require(std::string_view who, std::initializer_list<std::string_view> channels) const;

    size_t bytes() const;
    void count(Items& items) const;              // for reports
    void describe(FieldVisitor& visitor) const;  // for --tap

  private:
    size_t size_ = 0;
};

WEFT_VALUE_TYPE(Samples, "Samples", "a renderer's sample buffer")

}  // namespace weft
