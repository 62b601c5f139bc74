#include "samples/record_file.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>

#include "graph/error.h"
#include "runtime/atomic_file.h"
#include "runtime/context.h"
#include "samples/little_endian.h"

namespace weft {
namespace {

constexpr std::string_view header_suffix = ".header";

bool is_file(const std::string& path) {
    struct stat info {};
    return ::stat(path.c_str(), &info) == 0 && S_ISREG(info.st_mode);
}

Array<float> binary_records(const FileBytes& file, const RecordHeader& header, Context& ctx) {
    const size_t count = header.records() * header.floats(), expected = count * sizeof(float);
    if (file.bytes.size() != expected)
        throw Error(
            fmt::format("{}: {} bytes; {} x {} pixels of {} samples of {} bytes make {}: the file "
                        "is {}",
                        file.name, file.bytes.size(), header.width, header.height, header.spp,
                        header.floats() * sizeof(float), expected,
                        file.bytes.size() < expected ? "cut short" : "not of this header"));
    if (reinterpret_cast<std::uintptr_t>(file.bytes.data()) % alignof(float) == 0)
        return {{reinterpret_cast<const float*>(file.bytes.data()), count}, file.owner};
    const std::shared_ptr<float[]> values(new float[count]);
    ctx.parallel(count, size_t{1} << 18, [&](size_t begin, size_t end) {
        std::memcpy(values.get() + begin, file.bytes.data() + begin * sizeof(float),
                    (end - begin) * sizeof(float));
    });
    return {{values.get(), count}, values};
}

class TextRecords {
  public:
    TextRecords(const FileBytes& file, size_t skip, size_t per_record)
        : file_(file), text_(file.text().substr(skip)), per_record_(per_record) {
        for (const char c : file.text().substr(0, skip)) line_ += c == '\n';
    }

    Array<float> read(size_t records) {
        // The shortest record is a digit and a comma for each number.
        if (text_.size() / (2 * per_record_ - 1) < records)
            throw Error(
                fmt::format("{}: {} bytes of text cannot hold {} records of {} numbers: the file "
                            "is cut short",
                            file_.name, text_.size(), records, per_record_));
        const size_t count = records * per_record_;
        const std::shared_ptr<float[]> values(new float[count]);
        for (size_t i = 0; i < records; ++i)
            read_one({values.get() + i * per_record_, per_record_}, i, records);
        skip_empty();
        if (!text_.empty())
            fail(fmt::format("more lines than the {} records of the header", records));
        return {{values.get(), count}, values};
    }

  private:
    [[noreturn]] void fail(const std::string& message) const {
        throw Error(fmt::format("{}:{}: {}", file_.name, line_ + 1, message));
    }
    void skip_empty() {
        while (!text_.empty() && (text_[0] == '\n' || text_[0] == '\r' || text_[0] == ' ')) {
            line_ += text_[0] == '\n';
            text_.remove_prefix(1);
        }
    }
    void blanks() {
        while (!text_.empty() && (text_[0] == ' ' || text_[0] == '\t' || text_[0] == '\r'))
            text_.remove_prefix(1);
    }
    void read_one(std::span<float> values, size_t record, size_t records) {
        skip_empty();
        if (text_.empty())
            fail(fmt::format("the text ends after {} of {} records: the file is cut short", record,
                             records));
        for (size_t i = 0; i < values.size(); ++i) {
            blanks();
            if (i > 0 && take_comma()) blanks();
            const auto [end, status] =
                std::from_chars(text_.data(), text_.data() + text_.size(), values[i]);
            if (status != std::errc() && status != std::errc::result_out_of_range)
                fail(fmt::format("{} numbers, then '{}'; expected {} with commas between them", i,
                                 text_.substr(0, std::min<size_t>(text_.find('\n'), 20)),
                                 values.size()));
            if (status == std::errc::result_out_of_range) values[i] = out_of_range(end);
            text_.remove_prefix(size_t(end - text_.data()));
        }
        blanks();
        if (take_comma()) blanks();
        if (!text_.empty() && text_[0] != '\n')
            fail(fmt::format("more than {} numbers", values.size()));
    }
    bool take_comma() {
        if (text_.empty() || text_[0] != ',') return false;
        text_.remove_prefix(1);
        return true;
    }
    // Too small for a float: 0; too large: infinite, which the check of values will find.
    float out_of_range(const char* end) const {
        double value = 0;
        std::from_chars(text_.data(), end, value);
        return float(value);
    }

    const FileBytes& file_;
    std::string_view text_;
    size_t per_record_;
    size_t line_ = 0;
};

void write_all(const std::string& path, const RecordHeader& header, Context& ctx,
               const std::function<void(size_t, std::span<float>)>& record) {
    std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "wb"),
                                                         &std::fclose);
    const auto fail = [&] {
        throw Error(fmt::format("cannot write '{}': {}", path, std::strerror(errno)));
    };
    if (!file) fail();
    std::vector<float> values(header.floats());
    fmt::memory_buffer text;
    const size_t records = header.records();
    for (size_t i = 0; i < records; ++i) {
        if (i % 4096 == 0) ctx.check_cancelled();
        std::fill(values.begin(), values.end(), 0.0f);
        record(i, values);
        if (header.text) {
            text.clear();
            for (const float value : values)
                fmt::format_to(std::back_inserter(text), "{:.9g},", value);
            text.push_back('\n');
            if (std::fwrite(text.data(), 1, text.size(), file.get()) != text.size()) fail();
        } else if (std::fwrite(values.data(), sizeof(float), values.size(), file.get()) !=
                   values.size()) {
            fail();
        }
    }
    if (std::fclose(file.release()) != 0) fail();
}

}  // namespace

std::optional<RecordFiles> find_record_files(const FileBytes& file) {
    if (is_record_header(file)) {
        // A header alone: its data lie beside it.
        if (file.on_disk && file.name.ends_with(header_suffix)) {
            const std::string data = file.name.substr(0, file.name.size() - header_suffix.size());
            if (is_file(data)) return RecordFiles{file, map_file(data)};
        }
        return RecordFiles{file, file};
    }
    const std::string beside = file.name + std::string(header_suffix);
    if (!file.on_disk || !is_file(beside)) return std::nullopt;
    FileBytes header = map_file(beside);
    if (!is_record_header(header)) return std::nullopt;
    return RecordFiles{std::move(header), file};
}

Array<float> read_records(const RecordFiles& files, const RecordHeader& header, Context& ctx) {
    const bool inside = files.header.bytes.data() == files.data.bytes.data();
    if (header.text)
        return TextRecords(files.data, inside ? header.size : 0, header.floats())
            .read(header.records());
    if (inside)
        throw Error(fmt::format(
            "{}: a header of binary data with no data beside it; expected them in "
            "'{}'",
            files.header.name,
            files.header.name.ends_with(header_suffix)
                ? files.header.name.substr(0, files.header.name.size() - header_suffix.size())
                : "NAME, and this header in NAME.header"));
    return binary_records(files.data, header, ctx);
}

void write_records(const std::string& path, const RecordHeader& header, Context& ctx,
                   const std::function<void(size_t, std::span<float>)>& record) {
    AtomicFile data(path), head(path + std::string(header_suffix));
    write_all(data.temporary(), header, ctx, record);
    {
        std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(
            std::fopen(head.temporary().c_str(), "wb"), &std::fclose);
        const std::string text = record_header_text(header);
        if (!file || std::fwrite(text.data(), 1, text.size(), file.get()) != text.size() ||
            std::fclose(file.release()) != 0)
            throw Error(fmt::format("cannot write '{}': {}", head.path(), std::strerror(errno)));
    }
    data.commit();
    head.commit();
}

}  // namespace weft
