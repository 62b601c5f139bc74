#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "graph/error.h"
#include "samples/record_file.h"

namespace weft {
namespace {

constexpr std::string_view coc_label = "CoC coefficients (coc radius = C0/w+C1):";
constexpr std::string_view matrix_label = "Pixel-to-camera matrix:";
constexpr std::string_view tlfr_fields = "x,y,z/w,w,u,v,t,r,g,b,a,mv_x,mv_y,mv_w,dwdx,dwdy";
constexpr std::string_view ilfr_fields =
    "x,y,w,u,v,t,r,g,b,pri_mv(3d),pri_normal(3d),albedo(3d),sec_origin(3d),sec_hitpoint(3d),"
    "sec_mv(3d),sec_normal(3d),direct(3d),sec_albedo(3d),sec_direct(3d)";

std::string_view trimmed(std::string_view text) {
    while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
    while (!text.empty() && (text.back() == ' ' || text.back() == '\t' || text.back() == '\r'))
        text.remove_suffix(1);
    return text;
}

class Lines {
  public:
    explicit Lines(const FileBytes& file) : file_(file), text_(file.text()) {}

    [[noreturn]] void fail(const std::string& message) const {
        throw Error(fmt::format("{}:{}: {}", file_.name, line_, message));
    }
    std::string_view peek() const {
        const std::string_view rest = text_.substr(used_, 4096);
        return trimmed(rest.substr(0, rest.find('\n')));
    }
    std::string_view next() {
        ++line_;
        const std::string_view line = peek();
        const size_t end = text_.find('\n', used_);
        used_ = end == text_.npos ? text_.size() : end + 1;
        return line;
    }
    // What follows `label` on the next line, which must begin with it.
    std::string_view after(std::string_view label) {
        const std::string_view line = next();
        if (!line.starts_with(label))
            fail(fmt::format("'{}'; expected '{} ...'", line.substr(0, 80), label));
        return trimmed(line.substr(label.size()));
    }
    int positive(std::string_view label) {
        const std::string_view text = after(label);
        int value = 0;
        const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (status != std::errc() || end != text.data() + text.size() || value < 1)
            fail(fmt::format("{} is '{}'; expected a whole number from 1", label,
                             text.substr(0, 80)));
        return value;
    }
    void floats(std::string_view label, std::span<float> values) {
        std::string_view text = after(label);
        for (size_t i = 0; i < values.size(); ++i) {
            text = trimmed(text);
            if (i > 0) {
                if (text.empty() || text[0] != ',') break_off(label, values.size());
                text = trimmed(text.substr(1));
            }
            const auto [end, status] =
                std::from_chars(text.data(), text.data() + text.size(), values[i]);
            if (status != std::errc() || !std::isfinite(values[i])) break_off(label, values.size());
            text.remove_prefix(size_t(end - text.data()));
        }
        if (text = trimmed(text); !text.empty() && text != ",") break_off(label, values.size());
    }
    size_t used() const { return used_; }

  private:
    [[noreturn]] void break_off(std::string_view label, size_t count) const {
        fail(fmt::format("'{}' needs {} numbers with commas between them", label, count));
    }
    const FileBytes& file_;
    std::string_view text_;
    size_t used_ = 0;
    int line_ = 0;
};

RecordKind read_version(Lines& lines) {
    const std::string_view text = lines.after("Version");
    float version = 0;
    const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), version);
    if (status == std::errc() && end == text.data() + text.size()) {
        if (version == 1.3f) return RecordKind::tlfr;
        if (version == 2.2f) return RecordKind::ilfr;
    }
    lines.fail(
        fmt::format("version {}; this program reads TLFR 1.3 and ILFR 2.2", text.substr(0, 40)));
}

}  // namespace

bool is_record_header(const FileBytes& file) {
    return file.text().starts_with("Version ");
}

RecordHeader read_record_header(const FileBytes& file) {
    Lines lines(file);
    RecordHeader header;
    header.kind = read_version(lines);
    header.width = lines.positive("Width");
    header.height = lines.positive("Height");
    header.spp = lines.positive("Samples per pixel");
    if (lines.peek().starts_with("Motion model")) lines.next();
    std::array<float, 2> coc;
    lines.floats(coc_label, coc);
    header.c0 = coc[0];
    header.c1 = coc[1];
    if (header.kind == RecordKind::ilfr) lines.floats(matrix_label, header.pixel_to_camera);
    const std::string_view encoding = lines.after("Encoding =");
    if (encoding != "text" && encoding != "binary")
        lines.fail(fmt::format("encoding '{}'; expected text or binary", encoding.substr(0, 40)));
    header.text = encoding == "text";
    const std::string_view fields = lines.next();
    if (!fields.starts_with("x,y,"))
        lines.fail(
            fmt::format("'{}'; expected the names of the fields, 'x,y,...'", fields.substr(0, 80)));
    header.size = lines.used();

    std::uint64_t records = std::uint64_t(header.width) * std::uint64_t(header.height);
    if (__builtin_mul_overflow(records, std::uint64_t(header.spp), &records) ||
        records > SIZE_MAX / 256)
        lines.fail(fmt::format("{} x {} pixels of {} samples are more than any file holds",
                               header.width, header.height, header.spp));
    return header;
}

std::string record_header_text(const RecordHeader& header) {
    const bool tlfr = header.kind == RecordKind::tlfr;
    std::string text = fmt::format("Version {}\nWidth {}\nHeight {}\nSamples per pixel {}\n",
                                   tlfr ? "1.3" : "2.2", header.width, header.height, header.spp);
    if (tlfr) text += "Motion model: perspective\n";
    text += fmt::format("{} {:.9g},{:.9g}\n", coc_label, header.c0, header.c1);
    if (!tlfr) {
        text += matrix_label;
        for (size_t i = 0; i < 16; ++i)
            text += fmt::format("{}{:.9g}", i == 0 ? " " : ",", header.pixel_to_camera[i]);
        text += '\n';
    }
    text += fmt::format("Encoding = {}\n{}\n", header.text ? "text" : "binary",
                        tlfr ? tlfr_fields : ilfr_fields);
    return text;
}

}  // namespace weft
