#include "render/gltf_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <map>
#include <set>

#include "graph/diagnostic.h"
#include "graph/error.h"
#include "image/picture_file.h"
#include "render/file_there.h"

namespace weft {
namespace {

// What a file may require. The others change what is seen, or hide the geometry.
const std::set<std::string, std::less<>> understood = {
    "KHR_lights_punctual",   "KHR_materials_emissive_strength",
    "KHR_materials_ior",     "KHR_materials_transmission",
    "KHR_materials_volume",  "KHR_materials_unlit",
    "KHR_texture_transform", "KHR_materials_pbrSpecularGlossiness",
    "KHR_mesh_quantization", "EXT_texture_webp"};
const std::map<std::string, const char*, std::less<>> ways_out = {
    {"KHR_draco_mesh_compression",
     "export it again without compression, or unpack it: npx @gltf-transform/cli cp IN OUT"},
    {"EXT_meshopt_compression",
     "export it again without compression, or unpack it: npx @gltf-transform/cli cp IN OUT"},
    {"KHR_texture_basisu", "export it again with PNG or JPEG textures"},
    {"EXT_mesh_gpu_instancing", "export it again with a node for each instance"}};

std::uint32_t word(const std::string& bytes, size_t at) {
    std::uint32_t value = 0;
    for (size_t i = 4; i-- > 0;) value = value << 8 | std::uint8_t(bytes[at + i]);
    return value;
}

// The JSON of a file; a GLB's chunks are checked on the way.
std::string json_of(const std::string& bytes, const std::string& path) {
    if (!bytes.starts_with("glTF")) return bytes;
    const auto broken = [&](const std::string& why) {
        throw Error(fmt::format("{}: not a whole GLB: {}", path, why));
    };
    if (bytes.size() < 20) broken(fmt::format("{} bytes", bytes.size()));
    if (word(bytes, 4) != 2)
        throw Error(fmt::format("{}: GLB version {}; only glTF 2.0 is read", path, word(bytes, 4)));
    const size_t length = word(bytes, 8), json = word(bytes, 12);
    if (length > bytes.size())
        broken(fmt::format("its header says {} bytes, the file has {}", length, bytes.size()));
    if (word(bytes, 16) != 0x4e4f534a || json < 1 || json % 4 != 0 || 20 + json > length)
        broken("its first chunk is not JSON");
    if (20 + json < length) {
        if (length - (20 + json) < 8) broken("its second chunk is cut short");
        const size_t binary = word(bytes, 20 + json);
        if (binary > length - (28 + json))
            broken(fmt::format("its second chunk says {} bytes, {} are left", binary,
                               length - (28 + json)));
    }
    return bytes.substr(20, json);
}

std::vector<std::string> texts(const Json& document, const char* key) {
    std::vector<std::string> all;
    if (const Json* list = document.find(key))
        for (const Json& item : list->items)
            if (item.is(Json::Kind::text)) all.push_back(item.text);
    return all;
}

// What must hold before tinygltf may see it.
Json checked_json(const std::string& text, const std::string& path) {
    std::vector<Diagnostic> findings;
    const auto source = std::make_shared<const Source>(Source{path, text});
    Json document = parse_json(source, findings);
    if (has_errors(findings))
        for (const Diagnostic& finding : findings)
            if (finding.level == Diagnostic::Level::error)
                throw Error(fmt::format("{}: not glTF: {}", where(finding.place), finding.message));
    if (!document.is(Json::Kind::object))
        throw Error(fmt::format("{}: not glTF: no JSON object", path));
    const Json* asset = document.find("asset");
    const Json* version = asset ? asset->find("version") : nullptr;
    if (!version || !version->is(Json::Kind::text))
        throw Error(fmt::format("{}: not glTF: 'asset' has no 'version'", path));
    if (!version->text.starts_with("2."))
        throw Error(
            fmt::format("{}: glTF {}; only 2.0 is read: convert it first", path, version->text));
    for (const std::string& name : texts(document, "extensionsRequired"))
        if (!understood.contains(name)) {
            const auto way = ways_out.find(name);
            throw Error(
                fmt::format("{}: requires the extension '{}', which is not read; {}", path, name,
                            way != ways_out.end() ? way->second : "export it again without it"));
        }
    return document;
}

// Buffers only: what tinygltf asks for beside them are pictures, which stay where they are.
struct Beside {
    std::string folder;
    std::set<std::string> buffers;
    std::string missing;
};

bool exists(const std::string& path, void* data) {
    const auto& beside = *static_cast<const Beside*>(data);
    return std::any_of(beside.buffers.begin(), beside.buffers.end(), [&](const std::string& name) {
        return path.ends_with(name) && file_there(path);
    });
}
std::string as_it_is(const std::string& path, void*) {
    return path;
}
bool read_whole(std::vector<unsigned char>* out, std::string* error, const std::string& path,
                void* data) {
    if (!exists(path, data)) return false;
    try {
        const std::string bytes = read_whole_file(path);
        out->assign(bytes.begin(), bytes.end());
        return true;
    } catch (const Error& e) {
        if (error) *error += e.what();
        return false;
    }
}
// What lies in a buffer is left there: tinygltf has not looked whether it does.
bool keep_encoded(tinygltf::Image* image, const int, std::string*, std::string*, int, int,
                  const unsigned char* bytes, int size, void*) {
    if (image->bufferView < 0) image->image.assign(bytes, bytes + std::max(size, 0));
    image->as_is = true;
    return true;
}

int hex(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    c = char(c | 0x20);
    return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

template <class T>
T load(const unsigned char* p) {
    T value;
    std::memcpy(&value, p, sizeof value);
    return value;
}

size_t size_of(int component_type) {
    const std::int32_t size = tinygltf::GetComponentSizeInBytes(std::uint32_t(component_type));
    return component_type == TINYGLTF_COMPONENT_TYPE_DOUBLE || size < 0 ? 0 : size_t(size);
}

float number(const unsigned char* p, int type, bool normalized) {
    switch (type) {
        case TINYGLTF_COMPONENT_TYPE_FLOAT:
            return load<float>(p);
        case TINYGLTF_COMPONENT_TYPE_BYTE: {
            const float v = load<std::int8_t>(p);
            return normalized ? std::max(v / 127.0f, -1.0f) : v;
        }
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return float(*p) / (normalized ? 255.0f : 1.0f);
        case TINYGLTF_COMPONENT_TYPE_SHORT: {
            const float v = load<std::int16_t>(p);
            return normalized ? std::max(v / 32767.0f, -1.0f) : v;
        }
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return float(load<std::uint16_t>(p)) / (normalized ? 65535.0f : 1.0f);
        default:
            return float(load<std::uint32_t>(p));
    }
}

std::uint32_t whole(const unsigned char* p, int type) {
    switch (type) {
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return *p;
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return load<std::uint16_t>(p);
        default:
            return load<std::uint32_t>(p);
    }
}

bool is_whole(int type) {
    return type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
           type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
           type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
}

}  // namespace

std::string decoded_uri(const std::string& uri) {
    std::string path;
    for (size_t i = 0; i < uri.size(); ++i)
        if (uri[i] == '%' && i + 2 < uri.size() && hex(uri[i + 1]) >= 0 && hex(uri[i + 2]) >= 0) {
            path += char(hex(uri[i + 1]) * 16 + hex(uri[i + 2]));
            i += 2;
        } else {
            path += uri[i];
        }
    return path;
}

GltfFile::GltfFile(const std::string& bytes, const std::string& path) : path_(path) {
    const Json document = checked_json(json_of(bytes, path), path);
    if (bytes.size() > std::numeric_limits<unsigned>::max())
        throw Error(fmt::format("{}: larger than 4 GB", path));
    Beside beside;
    beside.folder = std::filesystem::path(path).parent_path().string();
    if (const Json* buffers = document.find("buffers"))
        for (const Json& buffer : buffers->items) {
            const Json* uri = buffer.find("uri");
            if (!uri || !uri->is(Json::Kind::text) || uri->text.starts_with("data:")) continue;
            const std::string name = decoded_uri(uri->text);
            const auto file = std::filesystem::path(beside.folder) / name;
            if (name.empty() || !file_there(file))
                throw Error(fmt::format("{}: buffer {}: no file '{}' beside it", path,
                                        &buffer - buffers->items.data(), name));
            beside.buffers.insert(name);
        }
    tinygltf::TinyGLTF loader;
    loader.SetImageLoader(keep_encoded, nullptr);
    loader.SetFsCallbacks({exists, as_it_is, read_whole, nullptr, &beside});
    std::string error, warning;
    bool good = false;
    try {
        good =
            bytes.starts_with("glTF")
                ? loader.LoadBinaryFromMemory(&model_, &error, &warning,
                                              reinterpret_cast<const unsigned char*>(bytes.data()),
                                              unsigned(bytes.size()), beside.folder)
                : loader.LoadASCIIFromString(&model_, &error, &warning, bytes.data(),
                                             unsigned(bytes.size()), beside.folder);
    } catch (const std::exception& e) {
        error = e.what();
    }
    if (good) return;
    while (!error.empty() && (error.back() == '\n' || error.back() == '.')) error.pop_back();
    std::replace(error.begin(), error.end(), '\n', ' ');
    throw Error(fmt::format("{}: not glTF 2.0: {}", path,
                            error.empty() ? "a part is missing or of the wrong kind" : error));
}

std::vector<std::string> GltfFile::unread_extensions() const {
    std::set<std::string> unread;
    for (const std::string& name : model_.extensionsUsed)
        if (!understood.contains(name)) unread.insert(name);
    return {unread.begin(), unread.end()};
}

void GltfFile::fail(const std::string& element, const std::string& why) const {
    throw Error(fmt::format("{}: {}: {}", path_, element, why));
}

size_t GltfFile::index(int i, size_t count, const std::string& element, const char* what) const {
    if (i < 0 || size_t(i) >= count) fail(element, fmt::format("{} {} of {}", what, i, count));
    return size_t(i);
}

const unsigned char* GltfFile::span(int buffer_view, size_t offset, size_t count, size_t stride,
                                    size_t size, const std::string& element) const {
    const auto& view =
        model_.bufferViews[index(buffer_view, model_.bufferViews.size(), element, "buffer view")];
    const auto& buffer =
        model_.buffers[index(view.buffer, model_.buffers.size(), element, "buffer")];
    const size_t held = buffer.data.size();
    if (view.byteOffset > held || view.byteLength > held - view.byteOffset)
        fail(element, fmt::format("buffer view {} reaches past the end of buffer {} ({} bytes)",
                                  buffer_view, view.buffer, held));
    const size_t room = view.byteLength;
    if (count > 0 && (offset > room || size > room - offset ||
                      (count - 1) > (room - offset - size) / std::max<size_t>(stride, 1)))
        fail(element, fmt::format("{} elements reach past the end of buffer view {} ({} bytes)",
                                  count, buffer_view, room));
    return buffer.data.data() + view.byteOffset + offset;
}

std::string GltfFile::bytes(int buffer_view, const std::string& element) const {
    const size_t size =
        model_.bufferViews[index(buffer_view, model_.bufferViews.size(), element, "buffer view")]
            .byteLength;
    const unsigned char* data = span(buffer_view, 0, size, 1, 1, element);
    return {data, data + size};
}

GltfFile::View GltfFile::view(int accessor, const std::string& element) const {
    const auto& a = model_.accessors[index(accessor, model_.accessors.size(), element, "accessor")];
    const std::string what = fmt::format("{}, accessor {}", element, accessor);
    View v;
    v.type = a.componentType;
    v.components = tinygltf::GetNumComponentsInType(std::uint32_t(a.type));
    v.normalized = a.normalized;
    v.count = a.count;
    const size_t size = size_of(a.componentType);
    if (size == 0 || v.components < 1)
        fail(what,
             fmt::format("component type {} of type {} is not glTF", a.componentType, a.type));
    if (a.bufferView < 0) {
        constexpr size_t most = size_t(1) << 24;
        if (v.count > most)
            fail(what, fmt::format("{} elements without a buffer view; at most {} are taken as 0",
                                   v.count, most));
        return v;
    }
    const auto& held =
        model_.bufferViews[index(a.bufferView, model_.bufferViews.size(), what, "buffer view")];
    const size_t packed = size * size_t(v.components);
    v.stride = held.byteStride > 0 ? held.byteStride : packed;
    if (v.stride < packed || v.stride > 252)
        if (held.byteStride > 0)
            fail(what, fmt::format("a stride of {} bytes for elements of {}", v.stride, packed));
    v.data = span(a.bufferView, a.byteOffset, v.count, v.stride, packed, what);
    return v;
}

std::vector<float> GltfFile::numbers(int accessor, int components,
                                     const std::string& element) const {
    const View v = view(accessor, element);
    const std::string what = fmt::format("{}, accessor {}", element, accessor);
    if (components > 0 && v.components != components)
        fail(what, fmt::format("{} numbers an element; expected {}", v.components, components));
    const size_t n = size_t(v.components), size = size_of(v.type);
    std::vector<float> all(v.count * n, 0.0f);
    if (v.data)
        for (size_t i = 0; i < v.count; ++i)
            for (size_t c = 0; c < n; ++c)
                all[i * n + c] = number(v.data + i * v.stride + c * size, v.type, v.normalized);
    const auto& sparse = model_.accessors[size_t(accessor)].sparse;
    if (sparse.isSparse && sparse.count > 0) {
        const size_t count = size_t(sparse.count),
                     index_size = size_of(sparse.indices.componentType);
        if (!is_whole(sparse.indices.componentType) || sparse.indices.byteOffset < 0 ||
            sparse.values.byteOffset < 0)
            fail(what, "its sparse part is damaged");
        const unsigned char* places =
            span(sparse.indices.bufferView, size_t(sparse.indices.byteOffset), count, index_size,
                 index_size, what);
        const unsigned char* values =
            span(sparse.values.bufferView, size_t(sparse.values.byteOffset), count, n * size,
                 n * size, what);
        for (size_t i = 0; i < count; ++i) {
            const size_t place = whole(places + i * index_size, sparse.indices.componentType);
            if (place >= v.count)
                fail(what, fmt::format("sparse index {} of {} elements", place, v.count));
            for (size_t c = 0; c < n; ++c)
                all[place * n + c] = number(values + (i * n + c) * size, v.type, v.normalized);
        }
    }
    for (size_t i = 0; i < all.size(); ++i)
        if (!std::isfinite(all[i])) fail(what, fmt::format("element {} is {}", i / n, all[i]));
    return all;
}

std::vector<Vec3> GltfFile::vectors(int accessor, const std::string& element) const {
    const std::vector<float> all = numbers(accessor, 3, element);
    std::vector<Vec3> out(all.size() / 3);
    for (size_t i = 0; i < out.size(); ++i) out[i] = {all[3 * i], all[3 * i + 1], all[3 * i + 2]};
    return out;
}

std::vector<std::uint32_t> GltfFile::indices(int accessor, const std::string& element) const {
    const View v = view(accessor, element);
    if (v.components != 1 || !is_whole(v.type) || v.normalized)
        fail(fmt::format("{}, accessor {}", element, accessor), "not a list of indices");
    if (model_.accessors[size_t(accessor)].sparse.isSparse)
        fail(fmt::format("{}, accessor {}", element, accessor), "sparse indices are not read");
    std::vector<std::uint32_t> all(v.count, 0);
    if (v.data)
        for (size_t i = 0; i < v.count; ++i) all[i] = whole(v.data + i * v.stride, v.type);
    return all;
}

}  // namespace weft
