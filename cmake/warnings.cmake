# aluminate_module(NAME sources...): the library target of one folder. Warnings are errors in our code only:
# third-party headers come in as SYSTEM.
function(aluminate_warnings target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Werror)
  # g++ 12 reports "may overlap" for every literal + std::string at -O3 (GCC bug 105651); later versions do not.
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    target_compile_options(${target} PRIVATE -Wno-restrict)
  endif()
endfunction()

function(aluminate_module name)
  add_library(${name} STATIC ${ARGN})
  target_include_directories(${name} PUBLIC ${PROJECT_SOURCE_DIR})
  aluminate_warnings(${name})
endfunction()

# aluminate_test(NAME SOURCES files... LIBRARIES targets...): one GoogleTest program, each case its own CTest.
function(aluminate_test name)
  cmake_parse_arguments(arg "" "" "SOURCES;LIBRARIES" ${ARGN})
  add_executable(${name} ${arg_SOURCES})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE ${arg_LIBRARIES} GTest::gtest GTest::gmock GTest::gtest_main)
  target_compile_definitions(${name} PRIVATE
    ALUMINATE_SOURCE_DIR="${PROJECT_SOURCE_DIR}"
    ALUMINATE_SHARED_DIR="${PROJECT_SOURCE_DIR}/../shared")   # public models and photos, may be absent: tests then skip
  aluminate_warnings(${name})
  add_test(NAME ${name} COMMAND ${name})
endfunction()
