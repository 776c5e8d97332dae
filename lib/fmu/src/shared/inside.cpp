// What the shared object holds of other libraries, because it must be whole by itself.
#include <fmt/format-inl.h>

// Debian has fmt as a shared library only; its functions that are no templates come from the header
// above, and these are the instances that the rest calls.
FMT_BEGIN_NAMESPACE
namespace detail {
template FMT_API auto dragonbox::to_decimal(float x) noexcept -> dragonbox::decimal_fp<float>;
template FMT_API auto dragonbox::to_decimal(double x) noexcept -> dragonbox::decimal_fp<double>;
template FMT_API locale_ref::locale_ref(const std::locale& loc);
template FMT_API auto locale_ref::get<std::locale>() const -> std::locale;
template FMT_API auto thousands_sep_impl(locale_ref) -> thousands_sep_result<char>;
template FMT_API auto decimal_point_impl(locale_ref) -> char;
template FMT_API void buffer<char>::append(const char*, const char*);
template FMT_API void vformat_to(buffer<char>&, string_view,
                                 basic_format_args<FMT_BUFFER_CONTEXT(char)>, locale_ref);
}  // namespace detail
FMT_END_NAMESPACE

// Debian's static yaml-cpp is compiled for programs: it takes this flag of libc for a variable of
// its own object, which in a shared object it must be. False: reference counts are always atomic.
extern "C" char __libc_single_threaded;
char __libc_single_threaded = 0;
