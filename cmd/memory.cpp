// Where the memory of the program comes from: frames that have no room in it go on in a file. All other forms of these
// operators call them, the sanitizers' too.

#include "batch/platform/scratch_memory.h"

#include <new>

using betamesh::allocateMemory;
using betamesh::releaseMemory;

void* operator new(std::size_t bytes) { return allocateMemory(bytes, alignof(std::max_align_t)); }
void* operator new(std::size_t bytes, std::align_val_t alignment) {
    return allocateMemory(bytes, static_cast<std::size_t>(alignment));
}
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept try {
    return allocateMemory(bytes, alignof(std::max_align_t));
} catch (const std::bad_alloc&) {
    return nullptr;
}
void* operator new(std::size_t bytes, std::align_val_t alignment, const std::nothrow_t&) noexcept try {
    return allocateMemory(bytes, static_cast<std::size_t>(alignment));
} catch (const std::bad_alloc&) {
    return nullptr;
}
void operator delete(void* block) noexcept { releaseMemory(block); }
void operator delete(void* block, std::size_t) noexcept { releaseMemory(block); }
void operator delete(void* block, std::align_val_t) noexcept { releaseMemory(block); }
void operator delete(void* block, std::size_t, std::align_val_t) noexcept { releaseMemory(block); }
