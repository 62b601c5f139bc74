// JsonFields: the members of one JSON object, asked for by name; what is of the wrong kind or out
// of range, and what nobody asked for, becomes a finding with its place.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "graph/diagnostic.h"
#include "render/affine.h"

namespace weft {

class JsonFields {
  public:
    // `what`: for messages ("a light"). Null or no object: a finding, and nothing in it.
    JsonFields(const Json* object, std::string what, std::vector<Diagnostic>& findings);

    bool has(std::string_view key) const { return object_ && object_->find(key); }
    const Json* any(std::string_view key);
    const Json* list(std::string_view key);  // null where it is not there
    const Json* object(std::string_view key);
    float number(std::string_view key, float fallback, double low = -1e30, double high = 1e30);
    bool flag(std::string_view key, bool fallback);
    std::string text(std::string_view key, const std::string& fallback = {});
    Vec3 vector(std::string_view key, Vec3 fallback);
    // A colour of numbers from 0 up: a list of three, or one number for grey.
    Vec3 color(std::string_view key, Vec3 fallback, double high = 1e30);
    std::vector<float> numbers(std::string_view key, size_t least, size_t most);
    // Which of `names`.
    size_t choice(std::string_view key, const std::vector<std::string>& names, size_t fallback);
    // "at", "rotate" (degrees about x, then y, then z), "scale" (one number or three).
    Affine placed();

    void finding(const Json* at, std::string message) const;
    // Findings for members that nobody asked for. Last.
    void end();

  private:
    const Json* object_;
    std::string what_;
    std::vector<Diagnostic>& findings_;
    std::vector<std::string> asked_;
};

// Throws the findings as one Error, a line each, where there are any.
void throw_findings(const std::vector<Diagnostic>& findings);

}  // namespace weft
