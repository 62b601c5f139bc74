// Types of values and streams, as the runtime sees them: a name, how to make one, how large it is,
// and what can be looked at in it.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace weft {

// Looks at the arrays of a value or of a batch (--tap). After children(), the arrays that follow
// belong to the children: those of record i are [offsets[i], offsets[i + 1]).
class FieldVisitor {
  public:
    virtual ~FieldVisitor() = default;
    virtual void field(std::string_view name, std::span<const float> values, int components = 1) = 0;
    virtual void field(std::string_view name, std::span<const std::uint32_t> values, int components = 1) = 0;
    virtual void children(std::string_view name, std::span<const std::uint32_t> offsets) = 0;
};

// How many of what a batch or value holds ("locations": 256), for reports and rates.
struct Items {
    struct Item {
        std::string_view name;  // a literal
        std::uint64_t count = 0;
    };
    void add(std::string_view name, std::uint64_t count);
    std::span<const Item> all() const { return {items_, used_}; }

  private:
    Item items_[6];
    size_t used_ = 0;
};

// Base of every batch of a stream: which records it holds. Set by the runtime, but for those of a
// source and of an output that selects, which say it themselves.
struct Batch {
    std::span<const std::uint32_t> pixels;   // of each record: y * width + x
    std::span<const std::uint32_t> parents;  // of a selection: each record's index in the batch it was taken from
    size_t size() const { return pixels.size(); }
};

struct TypeInfo {
    std::string_view name, about;
    bool stream = false;
    std::shared_ptr<void> (*make)() = nullptr;
    Batch* (*batch)(void*) = nullptr;                          // streams: its base
    void (*count)(const void*, Items&) = nullptr;              // T::count(Items&), or nothing
    size_t (*bytes)(const void*) = nullptr;                    // T::bytes(), or null
    void (*describe)(const void*, FieldVisitor&) = nullptr;    // T::describe(FieldVisitor&), or null
};

template <class T>
struct TypeOf;  // specialised by the macros below

template <class T>
const TypeInfo& type_info() {
    static const TypeInfo info = [] {
        TypeInfo i;
        i.name = TypeOf<T>::name;
        i.about = TypeOf<T>::about;
        i.stream = TypeOf<T>::stream;
        i.make = [] { return std::shared_ptr<void>(std::make_shared<T>()); };
        if constexpr (TypeOf<T>::stream)
            i.batch = [](void* p) -> Batch* { return static_cast<T*>(p); };
        if constexpr (requires(const T& v, Items& n) { v.count(n); })
            i.count = [](const void* p, Items& n) { static_cast<const T*>(p)->count(n); };
        if constexpr (requires(const T& v) { v.bytes(); })
            i.bytes = [](const void* p) { return static_cast<const T*>(p)->bytes(); };
        if constexpr (requires(const T& v, FieldVisitor& f) { v.describe(f); })
            i.describe = [](const void* p, FieldVisitor& f) { static_cast<const T*>(p)->describe(f); };
        return i;
    }();
    return info;
}

}  // namespace weft

// In namespace weft, after the type's definition. A value is whole and immutable once made; a stream
// type derives from Batch and is reused from batch to batch, so it keeps its memory.
#define WEFT_VALUE_TYPE(Type, Name, About)                     \
    template <>                                                \
    struct TypeOf<Type> {                                      \
        static constexpr std::string_view name = Name, about = About; \
        static constexpr bool stream = false;                  \
    };
#define WEFT_STREAM_TYPE(Type, Name, About)                    \
    template <>                                                \
    struct TypeOf<Type> {                                      \
        static constexpr std::string_view name = Name, about = About; \
        static constexpr bool stream = true;                   \
    };
