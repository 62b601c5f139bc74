// ColorConfig: an OpenColorIO config and the transforms asked of it.
// Which config: the one named (a node's `config`), else $OCIO, else the one Weft ships.
// A scene space that the config lacks and the shipped one has is joined through aces_interchange.
// Errors name the config and the names it knows. Threads: everything here may be shared.
#pragma once
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace weft {

// Maps RGB pixels in place.
class ColorTransform {
  public:
    void apply(float* rgb, size_t pixels) const;  // rgb: pixels x 3, finite
    bool is_identity() const;

    std::string color_space;    // of the result
    std::string display, view;  // set by ColorConfig::display()

  private:
    friend class ColorConfig;
    struct Steps;
    std::shared_ptr<const Steps> steps_;
};

class ColorConfig {
  public:
    // Kept for the life of the program: the next to ask for the same file gets the same object.
    static std::shared_ptr<const ColorConfig> open(const std::string& path);
    static std::shared_ptr<const ColorConfig> shipped();
    // What open(path) reads and `path` does not say: $OCIO's file, or nothing.
    static std::vector<std::string> further_files(const std::string& path);

    const std::string& name() const { return name_; }  // "weft-1", or the file's path
    std::string label()
        const;  // what a picture made with it says: the config's own name, or its file's

    ColorTransform convert(const std::string& from, const std::string& to) const;
    // Empty display or view: the config's default. `looks` in place of the view's own where not
    // empty.
    ColorTransform display(const std::string& from, const std::string& display,
                           const std::string& view, const std::string& looks = {}) const;
    ColorTransform look(const std::string& from, const std::string& looks, bool inverse) const;

    std::vector<std::string> color_spaces() const;  // names, without aliases
    std::vector<std::string> displays() const;
    std::vector<std::string> views(const std::string& display) const;

    struct Impl;
    explicit ColorConfig(std::shared_ptr<const Impl> impl, std::string name);

  private:
    std::shared_ptr<const Impl> impl_;
    std::string name_;
};

}  // namespace weft
