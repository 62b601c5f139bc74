// ByteWriter, ByteReader: values as bytes, for what a shard hands to the merge. Plain numbers and structs
// of them, arrays with their length before them, text. What is read is checked against what is there:
// bytes that are damaged or not the node's own are an Error, never a wild access.
#pragma once
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "graph/error.h"

namespace weft {

class ByteWriter {
  public:
    template <class T>
    void put(const T& value) {
        static_assert(std::is_trivially_copyable_v<T>);
        append(&value, sizeof value);
    }
    template <class T>
    void put_all(std::span<const T> values) {
        static_assert(std::is_trivially_copyable_v<T>);
        put(std::uint64_t(values.size()));
        append(values.data(), values.size_bytes());
    }
    template <class T>
    void put_all(const std::vector<T>& values) {
        put_all(std::span<const T>(values));
    }
    void put_text(std::string_view text) { put_all(std::span<const char>(text.data(), text.size())); }

    std::span<const std::byte> bytes() const { return bytes_; }
    void clear() { bytes_.clear(); }  // keeps its memory

  private:
    void append(const void* from, size_t size) {
        const auto* begin = static_cast<const std::byte*>(from);
        bytes_.insert(bytes_.end(), begin, begin + size);
    }
    std::vector<std::byte> bytes_;
};

class ByteReader {
  public:
    explicit ByteReader(std::vector<std::byte> bytes) : bytes_(std::move(bytes)) {}

    template <class T>
    T take() {
        static_assert(std::is_trivially_copyable_v<T>);
        T value;
        copy(&value, 1, sizeof value);
        return value;
    }
    // What put_all() wrote, into a place of just that size.
    template <class T>
    void fill(std::span<T> values) {
        static_assert(std::is_trivially_copyable_v<T>);
        if (take<std::uint64_t>() != values.size()) throw Error("holds an array of another length than this graph makes");
        copy(values.data(), values.size(), sizeof(T));
    }
    template <class T>
    void fill(std::vector<T>& values) {
        fill(std::span<T>(values));
    }
    // What put_all() wrote, however long.
    template <class T>
    std::vector<T> take_all() {
        const auto count = take<std::uint64_t>();
        if (count > (bytes_.size() - at_) / sizeof(T)) throw Error("ends before its data does");
        std::vector<T> values(count);
        copy(values.data(), values.size(), sizeof(T));
        return values;
    }
    std::string take_text() {
        const std::vector<char> text = take_all<char>();
        return {text.begin(), text.end()};
    }
    size_t left() const { return bytes_.size() - at_; }

  private:
    void copy(void* to, size_t count, size_t each) {
        if (count > (bytes_.size() - at_) / each) throw Error("ends before its data does");
        if (count > 0) std::memcpy(to, bytes_.data() + at_, count * each);
        at_ += count * each;
    }
    std::vector<std::byte> bytes_;
    size_t at_ = 0;
};

// The pieces of a divided value, wherever they lie. Threads: read() may be called by several at once.
class Pieces {
  public:
    virtual ~Pieces() = default;
    virtual size_t size() const = 0;
    virtual ByteReader read(size_t index) const = 0;
};

}  // namespace weft
