// The caller's own memory functions, for what the caller allocates through the C API.
#include <atomic>
#include <cstdlib>

#include "crgBaseLib.h"

namespace {

std::atomic<void* (*)(size_t, size_t)> own_calloc = nullptr;
std::atomic<void* (*)(void*, size_t)> own_realloc = nullptr;
std::atomic<void (*)(void*)> own_free = nullptr;

}  // namespace

// NOLINTBEGIN(cppcoreguidelines-no-malloc): that is what they are
void* crgCalloc(size_t nmemb, size_t size) {
  void* (*func)(size_t, size_t) = own_calloc;
  return func != nullptr ? func(nmemb, size) : std::calloc(nmemb, size);
}

void* crgRealloc(void* ptr, size_t size) {
  void* (*func)(void*, size_t) = own_realloc;
  return func != nullptr ? func(ptr, size) : std::realloc(ptr, size);
}

void crgFree(void* ptr) {
  void (*func)(void*) = own_free;
  func != nullptr ? func(ptr) : std::free(ptr);
}
// NOLINTEND(cppcoreguidelines-no-malloc)

void crgCallocSetCallback(void* (*func)(size_t nmemb, size_t size)) { own_calloc = func; }
void crgReallocSetCallback(void* (*func)(void* ptr, size_t size)) { own_realloc = func; }
void crgFreeSetCallback(void (*func)(void* ptr)) { own_free = func; }
