# Shared build rules: flags, module declaration, test declaration.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE_PROGRAM})
endif()

find_package(Eigen3 3.4 REQUIRED NO_MODULE)
if(NACRE_BUILD_ENCODER)
  find_package(TBB REQUIRED)
  set(CGAL_DO_NOT_WARN_ABOUT_CMAKE_BUILD_TYPE TRUE)
  find_package(CGAL 5.5 REQUIRED)
endif()

# Every target gets the same flags from here. Contraction is off so that positions are bit-identical
# in every build; errno-free math keeps sqrt a single instruction without changing its value.
add_library(nacre_flags INTERFACE)
target_include_directories(nacre_flags INTERFACE ${PROJECT_SOURCE_DIR})
target_compile_options(nacre_flags INTERFACE -ffp-contract=off -fno-math-errno
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Wnon-virtual-dtor)
if(NACRE_SANITIZE)
  target_compile_options(nacre_flags INTERFACE -fsanitize=${NACRE_SANITIZE} -fno-omit-frame-pointer)
  target_link_options(nacre_flags INTERFACE -fsanitize=${NACRE_SANITIZE})
endif()

# nacre_add_module(NAME [DECODE sources...] [SOURCES sources...] [DEPENDS targets...])
# DECODE sources join nacre_decode; SOURCES make the folder's own encoder-side library, nacre::NAME,
# which always brings nacre_decode along.
function(nacre_add_module name)
  cmake_parse_arguments(ARG "" "" "DECODE;SOURCES;DEPENDS" ${ARGN})
  if(ARG_DECODE)
    list(TRANSFORM ARG_DECODE PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/)
    target_sources(nacre_decode PRIVATE ${ARG_DECODE})
  endif()
  if(NOT NACRE_BUILD_ENCODER)
    return()
  endif()
  if(ARG_SOURCES)
    add_library(nacre_${name} STATIC ${ARG_SOURCES})
    target_link_libraries(nacre_${name} PUBLIC nacre_decode ${ARG_DEPENDS})
  else()
    add_library(nacre_${name} INTERFACE)
    target_link_libraries(nacre_${name} INTERFACE nacre_decode ${ARG_DEPENDS})
  endif()
  add_library(nacre::${name} ALIAS nacre_${name})
endfunction()

# nacre_add_test(NAME SOURCES sources... DEPENDS targets... [LABELS labels...])
function(nacre_add_test name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS;LABELS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE ${ARG_DEPENDS} nacre_test_support GTest::gtest_main)
  gtest_discover_tests(${name} DISCOVERY_TIMEOUT 60
    PROPERTIES TIMEOUT 600 LABELS "${ARG_LABELS}")
endfunction()
