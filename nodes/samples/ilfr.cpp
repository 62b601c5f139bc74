#include "samples/ilfr.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "graph/error.h"
#include "runtime/context.h"
#include "samples/channel_choice.h"
#include "samples/check_samples.h"
#include "samples/record_channels.h"

namespace weft {
namespace {

enum : size_t {
    x = 0,
    w = 2,
    u = 3,
    t = 5,
    r = 6,
    pri_mv = 9,
    pri_normal = 12,
    albedo = 15,
    sec_origin = 18,
    sec_hitpoint = 21,
    sec_mv = 24,
    sec_normal = 27,
    direct = 30,
    sec_albedo = 33,
    sec_direct = 36,
    width = 39
};

// Columns that are channels as they stand.
struct Field {
    std::string_view channel;
    size_t first, components;
};
constexpr std::array fields = {
    Field{"xy", x, 2},
    Field{"uv", u, 2},
    Field{"t", t, 1},
    Field{"rgb", r, 3},
    Field{"bandwidth", w, 1},
    Field{"primary_motion", pri_mv, 3},
    Field{"normal", pri_normal, 3},
    Field{"albedo", albedo, 3},
    Field{"position", sec_origin, 3},
    Field{"position2", sec_hitpoint, 3},
    Field{"secondary_motion", sec_mv, 3},
    Field{"normal2", sec_normal, 3},
    Field{"direct", direct, 3},
    Field{"albedo2", sec_albedo, 3},
    Field{"secondary_direct", sec_direct, 3},
};

using Vector = std::array<double, 3>;
using Matrix = std::array<Vector, 3>;

Vector times(const Matrix& m, const Vector& p) {
    Vector result{};
    for (size_t i = 0; i < 3; ++i) result[i] = m[i][0] * p[0] + m[i][1] * p[1] + m[i][2] * p[2];
    return result;
}

// By cofactors; false if there is none.
bool invert(const Matrix& m, Matrix& inverse) {
    const auto minor_of = [&](size_t i, size_t j) {
        const size_t a = (i + 1) % 3, b = (i + 2) % 3, c = (j + 1) % 3, d = (j + 2) % 3;
        return m[a][c] * m[b][d] - m[a][d] * m[b][c];
    };
    const double det =
        m[0][0] * minor_of(0, 0) + m[0][1] * minor_of(0, 1) + m[0][2] * minor_of(0, 2);
    if (!std::isfinite(det) || det == 0) return false;
    for (size_t i = 0; i < 3; ++i)
        for (size_t j = 0; j < 3; ++j) inverse[j][i] = minor_of(i, j) / det;
    return true;
}

// M's columns for x, y and 1 make the point in focus that a pixel sees: a ray's direction D (x, y,
// 1). A camera point p is l D (x, y, 1) for some l, so (x z, y z, z) = f D^-1 p with f the depth in
// focus.
Matrix camera_to_pixel(const RecordHeader& header, const std::string& file) {
    const auto& m = header.pixel_to_camera;
    Matrix directions, inverse{};
    const double scale = m[15];
    for (size_t i = 0; i < 3; ++i)
        directions[i] = {m[4 * i] / scale, m[4 * i + 1] / scale, m[4 * i + 3] / scale};
    const double focus = directions[2][0] * header.width / 2 +
                         directions[2][1] * header.height / 2 + directions[2][2];
    if (m[12] != 0 || m[13] != 0 || scale == 0 || focus == 0 || !invert(directions, inverse))
        throw Error(
            fmt::format("{}: its pixel-to-camera matrix does not take pixels to a plane before "
                        "the camera, so depth cannot be told",
                        file));
    for (Vector& row : inverse)
        for (double& value : row) value *= std::abs(focus);
    return inverse;
}

Json matrix_json(std::span<const double> values, size_t columns_in_row) {
    Json rows = Json::list();
    for (size_t i = 0; i < values.size(); i += columns_in_row) {
        Json row = Json::list();
        for (size_t k = 0; k < columns_in_row; ++k) row.items.emplace_back(values[i + k]);
        rows.items.push_back(std::move(row));
    }
    return rows;
}

Json camera_json(const RecordHeader& header, const Matrix& to_pixel) {
    std::array<double, 16> identity{}, raw{};
    std::array<double, 9> projection{};
    for (size_t i = 0; i < 16; ++i) {
        identity[i] = i % 5 == 0;
        raw[i] = header.pixel_to_camera[i];
    }
    for (size_t i = 0; i < 9; ++i) projection[i] = to_pixel[i / 3][i % 3];
    Json camera = Json::object();
    camera.set("world_to_camera", matrix_json(identity, 4));
    camera.set("camera_to_pixel", matrix_json(projection, 3));
    camera.set("pixel_to_camera", matrix_json(raw, 4));
    return camera;
}

// The matrix of a buffer that was read from ILFR with its positions; none otherwise.
std::optional<std::array<float, 16>> matrix_as_read(const Samples& samples) {
    if (!samples.find("position") || !samples.find("secondary_motion")) return std::nullopt;
    const Json* camera = samples.meta.find("camera");
    const Json* rows = camera ? camera->find("pixel_to_camera") : nullptr;
    if (!rows || rows->items.size() != 4) return std::nullopt;
    std::array<float, 16> matrix;
    for (size_t i = 0; i < 4; ++i) {
        if (rows->items[i].items.size() != 4) return std::nullopt;
        for (size_t k = 0; k < 4; ++k) matrix[4 * i + k] = float(rows->items[i].items[k].number);
    }
    return matrix;
}

// A camera space of pixels: (x, y, 1) at depth 1. The plane in focus is where c0 / z + c1 is 0.
std::array<float, 16> matrix_of_pixels(const Samples& samples) {
    const double depth = samples.lens ? -double(samples.lens->c0) / samples.lens->c1 : 0;
    const float focus = std::isfinite(depth) && depth > 0 ? float(depth) : 1.0f;
    return {focus, 0, 0, 0, 0, focus, 0, 0, 0, 0, 0, focus, 0, 0, 0, 1};
}

// The primary hit and its motion, in the camera space of pixels.
void put_point(const Samples& samples, size_t i, std::span<float> record, size_t& lost_motion) {
    const auto xy = samples.xy(), uv = samples.uv(), motion = samples.motion();
    const bool infinite = std::isinf(samples.z()[i]);
    const double z = infinite ? double(record_infinity) : double(samples.z()[i]);
    const Lens lens = samples.lens.value_or(Lens{});
    const double slope = infinite ? lens.c1 : lens.c0 / z + lens.c1;
    for (size_t k = 0; k < 2; ++k) {
        const double centre = xy[2 * i + k] - (uv.empty() ? 0 : slope * uv[2 * i + k]);
        record[sec_origin + k] = float(centre * z);
    }
    record[sec_origin + 2] = float(z);
    for (size_t k = 0; k < 3 && !motion.empty(); ++k) record[sec_mv + k] = motion[3 * i + k];
    if (!infinite) return;
    lost_motion += record[sec_mv] != 0 || record[sec_mv + 1] != 0 || record[sec_mv + 2] != 0;
    record[sec_mv] = record[sec_mv + 1] = record[sec_mv + 2] = 0;
}

}  // namespace

Samples read_ilfr(const RecordFiles& files, const RecordHeader& header, const ReadOptions& options,
                  Context& ctx) {
    std::vector<std::string> known{"z", "motion"};
    for (const Field& field : fields) known.emplace_back(field.channel);
    refuse_unknown_channels(options, files.data.name, known);
    const Matrix to_pixel = camera_to_pixel(header, files.header.name);
    const Array<float> records = read_records(files, header, ctx);

    Samples samples = samples_of_header(header);
    samples.meta = Json::object();
    samples.meta.set("camera", camera_json(header, to_pixel));
    for (const Field& field : fields)
        if (is_wanted(options, field.channel))
            samples.add(Channel{std::string(field.channel),
                                int(field.components),
                                standard_role(field.channel),
                                columns(records, width, field.first, field.components, ctx),
                                {}});

    std::vector<float> z(samples.size()), motion(3 * samples.size());
    ctx.parallel(samples.size(), size_t{1} << 16, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const float* record = records.view().data() + i * width;
            const auto vector = [&](size_t at) {
                return Vector{record[at], record[at + 1], record[at + 2]};
            };
            z[i] = float(times(to_pixel, vector(sec_origin))[2]);
            const Vector moved = times(to_pixel, vector(sec_mv));
            for (size_t k = 0; k < 3; ++k)
                motion[3 * i + k] = z[i] >= record_infinity ? 0 : float(moved[k]);
        }
    });
    restore_infinite_depth(z);
    samples.add("z", 1, std::move(z));
    samples.add("motion", 3, std::move(motion));
    drop_idle_channels(samples);
    check_samples(samples, files.data.name, options.tolerate, ctx);
    return samples;
}

void write_ilfr(const Samples& samples, const std::string& path, bool text, Context& ctx) {
    check_record_writable(samples, path, SampleFormat::ilfr,
                          {"xy", "uv", "t", "z", "motion", "rgb", "bandwidth", "primary_motion",
                           "normal", "albedo", "position", "position2", "secondary_motion",
                           "normal2", "direct", "albedo2", "secondary_direct"},
                          ctx);
    RecordHeader header;
    header.kind = RecordKind::ilfr;
    header.width = samples.width;
    header.height = samples.height;
    header.spp = samples.spp;
    header.text = text;
    if (samples.lens) header.c0 = samples.lens->c0, header.c1 = samples.lens->c1;
    const auto as_read = matrix_as_read(samples);
    header.pixel_to_camera = as_read ? *as_read : matrix_of_pixels(samples);
    if (!as_read && samples.find("position"))
        ctx.warn(fmt::format(
            "{}: written in a camera space of pixels, in which depth and motion are exact; "
            "'position' is made from xy and z",
            path));

    size_t lost_motion = 0;
    write_records(path, header, ctx, [&](size_t i, std::span<float> record) {
        for (const Field& field : fields) {
            const auto values = samples.values(field.channel);
            for (size_t k = 0; k < field.components && !values.empty(); ++k)
                record[field.first + k] = values[i * field.components + k];
        }
        if (!as_read) put_point(samples, i, record, lost_motion);
    });
    if (lost_motion > 0)
        ctx.warn(fmt::format(
            "{}: ILFR 2.2 holds no motion of what is infinitely far: that of {} sample{} "
            "is written as 0",
            path, lost_motion, lost_motion == 1 ? "" : "s"));
}

}  // namespace weft
