// LargeArray: a vector for many megabytes. On huge pages that are used again (large_pages.h), where
// the system has them to give: a fault for each 4 KiB costs more than writing them. And resize()
// leaves new elements as they are, to be written in parallel by whoever fills them.
#pragma once
#include <cstddef>
#include <memory>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

#include "runtime/large_pages.h"

namespace weft {

template <class T>
struct LargeAllocator {
    static_assert(std::is_trivially_copyable_v<T>);
    using value_type = T;

    LargeAllocator() = default;
    template <class U>
    LargeAllocator(const LargeAllocator<U>&) noexcept {}

    T* allocate(size_t n) {
        return static_cast<T*>(is_large(n) ? take_large_pages(n * sizeof(T))
                                           : ::operator new(n * sizeof(T)));
    }
    void deallocate(T* memory, size_t n) noexcept {
        if (is_large(n))
            give_large_pages(memory, n * sizeof(T));
        else
            ::operator delete(memory);
    }
    // What fills most of a huge page, or more.
    static bool is_large(size_t n) { return n * sizeof(T) >= large_page - large_page / 4; }
    template <class U>
    void construct(U* at) noexcept {
        ::new (static_cast<void*>(at)) U;
    }
    template <class U, class... Args>
    void construct(U* at, Args&&... args) {
        ::new (static_cast<void*>(at)) U(std::forward<Args>(args)...);
    }
    template <class U>
    bool operator==(const LargeAllocator<U>&) const noexcept {
        return true;
    }
};

template <class T>
using LargeArray = std::vector<T, LargeAllocator<T>>;

}  // namespace weft
