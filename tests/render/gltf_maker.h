// GltfMaker: glTF documents for tests, with their numbers in a data URI or a GLB's second chunk.
#pragma once
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace weft {

class GltfMaker {
  public:
    // Returns the accessor's number.
    int floats(const std::vector<float>& values, const char* type) {
        static const std::vector<std::pair<std::string, size_t>> sizes = {
            {"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT4", 16}};
        size_t each = 1;
        for (const auto& [name, n] : sizes)
            if (name == type) each = n;
        return accessor(values.data(), values.size() * 4, 5126, values.size() / each, type);
    }
    int shorts(const std::vector<std::uint16_t>& values, const char* type = "SCALAR",
               size_t each = 1) {
        return accessor(values.data(), values.size() * 2, 5123, values.size() / each, type);
    }
    int bytes_view(const std::string& bytes) { return view(bytes.data(), bytes.size()); }

    // `rest`: the document's other members, "nodes" and so on.
    std::string text(const std::string& rest) const {
        return fmt::format(
            R"({{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":{},"uri":"data:application/octet-stream;base64,{}"}}],"bufferViews":[{}],"accessors":[{}]{}{}}})",
            data_.size(), base64(data_), views_, accessors_, rest.empty() ? "" : ",", rest);
    }
    std::string glb(const std::string& rest) const {
        std::string json = fmt::format(
            R"({{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":{}}}],"bufferViews":[{}],"accessors":[{}]{}{}}})",
            data_.size(), views_, accessors_, rest.empty() ? "" : ",", rest);
        json.resize((json.size() + 3) / 4 * 4, ' ');
        std::string data = data_;
        data.resize((data.size() + 3) / 4 * 4, '\0');
        const auto word = [](size_t v) {
            std::string s(4, '\0');
            for (size_t i = 0; i < 4; ++i) s[i] = char(v >> (8 * i));
            return s;
        };
        return "glTF" + word(2) + word(28 + json.size() + data.size()) + word(json.size()) +
               "JSON" + json + word(data.size()) + std::string("BIN\0", 4) + data;
    }

  private:
    int view(const void* values, size_t size) {
        data_.resize((data_.size() + 3) / 4 * 4, '\0');
        views_ += fmt::format(R"({}{{"buffer":0,"byteOffset":{},"byteLength":{}}})",
                              views_.empty() ? "" : ",", data_.size(), size);
        data_.append(static_cast<const char*>(values), size);
        return views_made_++;
    }
    int accessor(const void* values, size_t size, int component, size_t count, const char* type) {
        const int v = view(values, size);
        accessors_ +=
            fmt::format(R"({}{{"bufferView":{},"componentType":{},"count":{},"type":"{}"}})",
                        accessors_.empty() ? "" : ",", v, component, count, type);
        return accessors_made_++;
    }
    static std::string base64(const std::string& bytes) {
        static const char* letters =
            "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
        std::string out;
        for (size_t i = 0; i < bytes.size(); i += 3) {
            std::uint32_t v = 0;
            for (size_t k = 0; k < 3; ++k)
                v = v << 8 | (i + k < bytes.size() ? std::uint8_t(bytes[i + k]) : 0u);
            for (size_t k = 0; k < 4; ++k)
                out += i + k <= bytes.size() ? letters[v >> (18 - 6 * k) & 63] : '=';
        }
        return out;
    }
    std::string data_, views_, accessors_;
    int views_made_ = 0, accessors_made_ = 0;
};

}  // namespace weft
