#include "page.h"

#include <cstddef>

#ifdef KERBSTONE_PAGE
asm(".section .rodata\n"
    ".global kerbstone_view_page_begin\n"
    ".global kerbstone_view_page_end\n"
    "kerbstone_view_page_begin:\n"
    ".incbin \"" KERBSTONE_PAGE
    "\"\n"
    "kerbstone_view_page_end:\n"
    ".byte 0\n"
    ".previous\n");
extern "C" const char kerbstone_view_page_begin[];
extern "C" const char kerbstone_view_page_end[];
#endif

namespace view {

std::string_view page() {
#ifdef KERBSTONE_PAGE
  return {kerbstone_view_page_begin,
          static_cast<std::size_t>(kerbstone_view_page_end - kerbstone_view_page_begin)};
#else
  return {};
#endif
}

}  // namespace view
