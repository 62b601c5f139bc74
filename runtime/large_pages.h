// Memory of large arrays: whole huge pages, which stay with the process when they are given back.
// The kernel clears pages that are new to a process, and a virtual machine may first have to fetch
// them from its host: that can cost more than all that is done with them. So who asks next gets
// those that were given back; when memory runs short the kernel takes them first (MADV_FREE).
#pragma once
#include <cstddef>

namespace weft {

inline constexpr size_t large_page = size_t(2) << 20;

// `bytes`, rounded up to whole pages of large_page, at a multiple of it. What is in it is
// undefined. Throws std::bad_alloc.
void* take_large_pages(size_t bytes);
void give_large_pages(void* memory, size_t bytes) noexcept;

}  // namespace weft
