// LargeArray: a vector for many megabytes. On huge pages, where the system has them to give: a
// fault for each 4 KiB costs more than writing them. And resize() leaves new elements as they are,
// to be written in parallel by whoever fills them.
#pragma once
#include <sys/mman.h>

#include <cstddef>
#include <memory>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

namespace weft {

template <class T>
struct LargeAllocator {
    static_assert(std::is_trivially_copyable_v<T>);
    using value_type = T;
    static constexpr size_t huge_page = size_t(2) << 20;

    LargeAllocator() = default;
    template <class U>
    LargeAllocator(const LargeAllocator<U>&) noexcept {}

    T* allocate(size_t n) {
        if (!is_large(n)) return static_cast<T*>(::operator new(n * sizeof(T)));
        const size_t bytes = (n * sizeof(T) + huge_page - 1) / huge_page * huge_page;
        void* memory = ::operator new(bytes, std::align_val_t(huge_page));
        madvise(memory, bytes, MADV_HUGEPAGE);  // where it is refused, small pages do
        return static_cast<T*>(memory);
    }
    void deallocate(T* memory, size_t n) noexcept {
        if (is_large(n))
            ::operator delete(memory, std::align_val_t(huge_page));
        else
            ::operator delete(memory);
    }
    // What fills most of a huge page, or more.
    static bool is_large(size_t n) { return n * sizeof(T) >= huge_page - huge_page / 4; }
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
