# The same bits from every compiler, optimisation level and CPU. Pixels and counters are integers or literal IEEE
# binary64 sequences, so the compiler must not fuse, reassociate or approximate them.

foreach(flags "${CMAKE_CXX_FLAGS}" "${CMAKE_CXX_FLAGS_DEBUG}" "${CMAKE_CXX_FLAGS_RELEASE}" "${CMAKE_CXX_FLAGS_RELWITHDEBINFO}" "$ENV{CXXFLAGS}")
  if(flags MATCHES "-(ffast-math|Ofast|funsafe-math-optimizations|fassociative-math|freciprocal-math|ffinite-math-only|mfpmath=387|ffp-contract=fast)")
    message(FATAL_ERROR "aluminate: ${CMAKE_MATCH_0} changes results; remove it from the compiler flags")
  endif()
endforeach()

add_compile_options(-ffp-contract=off -fno-fast-math)

include(CheckCXXSourceRuns)
set(CMAKE_REQUIRED_FLAGS "-ffp-contract=off -fno-fast-math")
check_cxx_source_runs([[
#include <cfloat>
#include <cstring>
#include <cstdint>
// 1 when a*b+c is rounded twice (no contraction), doubles are evaluated as doubles and denormals survive.
int main() {
  volatile double a = 1.0 + 0x1p-30, b = 1.0 - 0x1p-30, c = -1.0;
  volatile double product = a * b;
  if (a * b + c != product + c) return 1;
  volatile double tiny = 0x1p-1074;
  return FLT_EVAL_METHOD == 0 && tiny * 1.0 != 0.0 && product == 1.0 ? 0 : 1;
}]] ALUMINATE_IEEE_ARITHMETIC)
unset(CMAKE_REQUIRED_FLAGS)
if(NOT ALUMINATE_IEEE_ARITHMETIC)
  message(FATAL_ERROR "aluminate: this compiler and its flags do not give plain IEEE binary64 arithmetic; results would differ")
endif()
