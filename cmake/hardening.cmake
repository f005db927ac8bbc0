# SPDX-License-Identifier: Apache-2.0
# Flags by which a fault of memory ends a program instead of being of use to somebody. Debian's dpkg-buildflags gives a
# package some of them already, by the environment: what is there is not given twice. MBGATE_HARDENED says, for
# tests/package/hardening_test.py, what a program must have.
include(CheckCXXCompilerFlag)
set(MBGATE_HARDENED link)

# `mark`: what such a flag has in it, whatever its value.
function(mbgate_harden mark)
  if(NOT "${CMAKE_CXX_FLAGS}" MATCHES "${mark}")
    foreach(flag IN LISTS ARGN)
      string(MAKE_C_IDENTIFIER "MBGATE_HAS${flag}" known)
      check_cxx_compiler_flag(${flag} ${known})
      if(${known})
        add_compile_options(${flag})
      endif()
    endforeach()
  endif()
endfunction()

# Everything is relocated when the program starts, and what was relocated is read-only then.
if(NOT "${CMAKE_EXE_LINKER_FLAGS}" MATCHES "-z,relro")
  add_link_options(-Wl,-z,relro)
endif()
if(NOT "${CMAKE_EXE_LINKER_FLAGS}" MATCHES "-z,now")
  add_link_options(-Wl,-z,now)
endif()

# The sanitizers find more, and do not go with these.
if(NOT MBGATE_SANITIZE AND NOT MBGATE_FUZZ)
  list(APPEND MBGATE_HARDENED code)
  mbgate_harden("-f(pie|PIE)" -fPIE)
  add_link_options(-pie)
  mbgate_harden("-fstack-protector" -fstack-protector-strong)
  mbgate_harden("-fstack-clash-protection" -fstack-clash-protection)
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|amd64|AMD64|i.86)$")
    mbgate_harden("-fcf-protection" -fcf-protection)
  elseif(CMAKE_SYSTEM_PROCESSOR MATCHES "^(aarch64|arm64)$")
    mbgate_harden("-mbranch-protection" -mbranch-protection=standard)
  endif()
  # The checks of the C library need an optimising compiler.
  string(TOUPPER "${CMAKE_BUILD_TYPE}" type)
  set(all_flags "${CMAKE_CXX_FLAGS} ${CMAKE_CXX_FLAGS_${type}}")
  if("${all_flags}" MATCHES "-D_FORTIFY_SOURCE=")
    list(APPEND MBGATE_HARDENED fortify)
  elseif(NOT type STREQUAL "DEBUG" AND "${all_flags}" MATCHES "-O[123s]")
    add_compile_options(-U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=3)
    list(APPEND MBGATE_HARDENED fortify)
  endif()
endif()
