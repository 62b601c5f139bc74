#include "samples/npy.h"

#include <fmt/format.h>

#include <charconv>

#include "graph/error.h"
#include "runtime/context.h"
#include "runtime/large_array.h"
#include "samples/convert.h"
#include "samples/file_bytes.h"
#include "samples/little_endian.h"

namespace weft {
namespace {

constexpr std::string_view magic = "\x93NUMPY";

// The header: {'descr': '<f4', 'fortran_order': False, 'shape': (460800, 2), }
class Header {
  public:
    Header(std::string_view text, const std::string& what) : rest_(text), what_(what) {}

    void parse(Npy& array) {
        expect('{');
        bool descr = false, order = false, shape = false;
        while (!take('}')) {
            const std::string_view key = quoted();
            expect(':');
            if (key == "descr")
                descr = read_descr(array);
            else if (key == "fortran_order")
                order = read_order();
            else if (key == "shape")
                shape = read_shape(array);
            else
                fail();
            if (!take(',')) {
                expect('}');
                break;
            }
        }
        if (!descr || !order || !shape) fail();
    }

  private:
    [[noreturn]] void fail() const {
        throw Error(what_ + " has a damaged array header; save it again with numpy");
    }
    void blanks() {
        while (!rest_.empty() && (rest_[0] == ' ' || rest_[0] == '\n')) rest_.remove_prefix(1);
    }
    bool take(char c) {
        blanks();
        if (rest_.empty() || rest_[0] != c) return false;
        rest_.remove_prefix(1);
        return true;
    }
    void expect(char c) {
        if (!take(c)) fail();
    }
    std::string_view quoted() {
        expect('\'');
        const size_t end = rest_.find('\'');
        if (end == rest_.npos) fail();
        const std::string_view word = rest_.substr(0, end);
        rest_.remove_prefix(end + 1);
        return word;
    }

    bool read_descr(Npy& array) {
        blanks();
        if (!rest_.empty() && rest_[0] == '[')
            throw Error(what_ + " is an array of records; save each field as an array of its own");
        const std::string_view descr = quoted();
        if (descr.size() < 2) fail();
        const std::string_view type = descr.substr(1);
        if (descr[0] == '>')
            throw Error(fmt::format("{} is big-endian ('{}'); save it with .astype('<{}')", what_,
                                    descr, type));
        if (type == "O")
            throw Error(what_ +
                        " is an array of Python objects; save numbers (f2, f4, f8, u1, u2, u4)");
        if (type != "f2" && type != "f4" && type != "f8" && type != "u1" && type != "u2" &&
            type != "u4")
            throw Error(
                fmt::format("{} has type '{}'; expected f2, f4, f8, u1, u2 or u4: save it "
                            "with .astype('f4') or .astype('u4')",
                            what_, descr));
        array.kind = type[0];
        array.item_size = type[1] - '0';
        return true;
    }
    bool read_order() {
        blanks();
        if (rest_.substr(0, 4) == "True")
            throw Error(what_ + " is in Fortran order; save it with numpy.ascontiguousarray()");
        if (rest_.substr(0, 5) != "False") fail();
        rest_.remove_prefix(5);
        return true;
    }
    bool read_shape(Npy& array) {
        expect('(');
        while (!take(')')) {
            blanks();
            std::uint64_t extent = 0;
            const auto [end, status] =
                std::from_chars(rest_.data(), rest_.data() + rest_.size(), extent);
            if (status != std::errc() || array.shape.size() == 32) fail();
            rest_.remove_prefix(size_t(end - rest_.data()));
            array.shape.push_back(extent);
            if (!take(',')) {
                expect(')');
                break;
            }
        }
        return true;
    }

    std::string_view rest_;
    const std::string& what_;
};

template <class T>
bool lies_right(std::span<const std::uint8_t> data) {
    return reinterpret_cast<std::uintptr_t>(data.data()) % alignof(T) == 0;
}

// Converts number by number in pieces of a quarter of a million. Pages of a mapped file go as they
// are copied.
template <class To, class Piece>
Array<To> converted(const Npy& array, Context& ctx, Piece&& piece) {
    const auto count = size_t(array.numbers());
    const auto values = std::make_shared<LargeArray<To>>(count);
    const auto item = size_t(array.item_size);
    ctx.parallel(count, size_t{1} << 18, [&](size_t begin, size_t end) {
        const auto from = array.data.subspan(begin * item, (end - begin) * item);
        piece(from, std::span(*values).subspan(begin, end - begin));
        forget_pages(from);
    });
    return {*values, values};
}

}  // namespace

Npy parse_npy(std::span<const std::uint8_t> bytes, const std::string& what) {
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (text.substr(0, magic.size()) != magic || bytes.size() < 10)
        throw Error(what + " is no numpy array");
    const int version = bytes[6];
    if (version < 1 || version > 3)
        throw Error(fmt::format("{} is a numpy array of version {}.{}; this program reads 1 to 3",
                                what, version, bytes[7]));
    const size_t head = version == 1 ? 10 : 12;
    if (bytes.size() < head) throw Error(what + " is cut short in its header");
    const size_t length = version == 1 ? u16(bytes, 8) : u32(bytes, 8);
    if (length > bytes.size() - head) throw Error(what + " is cut short in its header");
    Npy array;
    Header(text.substr(head, length), what).parse(array);
    array.data = bytes.subspan(head + length);
    std::uint64_t expected = std::uint64_t(array.item_size);
    bool overflow = false;
    for (const std::uint64_t extent : array.shape)
        overflow |= __builtin_mul_overflow(expected, extent, &expected);
    if (overflow || expected != array.data.size())
        throw Error(fmt::format("{} says it is {} numbers of {} bytes but holds {} bytes", what,
                                shape_text(array.shape), array.item_size, array.data.size()));
    return array;
}

std::string shape_text(const std::vector<std::uint64_t>& shape) {
    return fmt::format("({}{})", fmt::join(shape, ", "), shape.size() == 1 ? "," : "");
}

Array<float> npy_floats(const Npy& array, const std::shared_ptr<const void>& owner, Context& ctx) {
    const auto whole = [](auto zero) {
        using From = decltype(zero);
        return [](std::span<const std::uint8_t> from, std::span<float> to) {
            for (size_t i = 0; i < to.size(); ++i)
                to[i] = float(number_at<From>(from, i * sizeof(From)));
        };
    };
    if (array.kind == 'u' && array.item_size == 1)
        return converted<float>(array, ctx, whole(std::uint8_t{}));
    if (array.kind == 'u' && array.item_size == 2)
        return converted<float>(array, ctx, whole(std::uint16_t{}));
    if (array.kind == 'u') return converted<float>(array, ctx, whole(std::uint32_t{}));
    if (array.item_size == 8) return converted<float>(array, ctx, whole(double{}));
    if (array.item_size == 2) return converted<float>(array, ctx, &floats_from_halves);
    if (lies_right<float>(array.data))
        return {{reinterpret_cast<const float*>(array.data.data()), size_t(array.numbers())},
                owner};
    return converted<float>(array, ctx, whole(float{}));
}

Array<std::uint32_t> npy_whole(const Npy& array, const std::shared_ptr<const void>& owner,
                               Context& ctx) {
    using Whole = std::uint32_t;
    const auto widened = [](auto zero) {
        using From = decltype(zero);
        return [](std::span<const std::uint8_t> from, std::span<Whole> to) {
            for (size_t i = 0; i < to.size(); ++i) to[i] = number_at<From>(from, i * sizeof(From));
        };
    };
    if (array.item_size == 1) return converted<Whole>(array, ctx, widened(std::uint8_t{}));
    if (array.item_size == 2) return converted<Whole>(array, ctx, widened(std::uint16_t{}));
    if (lies_right<Whole>(array.data))
        return {{reinterpret_cast<const Whole*>(array.data.data()), size_t(array.numbers())},
                owner};
    return converted<Whole>(array, ctx, widened(Whole{}));
}

std::string npy_header(std::string_view descr, const std::vector<std::uint64_t>& shape) {
    std::string text = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': {}, }}",
                                   descr, shape_text(shape));
    const size_t used = 10 + text.size() + 1;
    text.append((64 - used % 64) % 64, ' ');
    text += '\n';
    std::string header(magic);
    header += {'\x01', '\x00', char(text.size() & 0xff), char(text.size() >> 8)};
    return header + text;
}

}  // namespace weft
