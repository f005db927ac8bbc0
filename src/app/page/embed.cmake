# SPDX-License-Identifier: Apache-2.0
# Writes a C++ source with the contents of files, as bytes: nothing in them can end a literal.
#   cmake -DOUTPUT=page_files.cpp -DFILES="a.html;b.js" -P embed.cmake
set(arrays "")
set(entries "")
set(count 0)
foreach(file IN LISTS FILES)
  get_filename_component(name ${file} NAME)
  file(READ ${file} bytes HEX)
  file(SHA256 ${file} hash)
  string(SUBSTRING ${hash} 0 16 hash)
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "'\\\\x\\1'," bytes "${bytes}")
  string(APPEND arrays "constexpr char kFile${count}[] = {${bytes}};\n")
  string(APPEND entries "    {\"${name}\", {kFile${count}, sizeof kFile${count}}, \"${hash}\"},\n")
  math(EXPR count "${count} + 1")
endforeach()
file(WRITE ${OUTPUT} "// Made by src/app/page/embed.cmake.
#include \"app/page/page_answer.hpp\"

namespace mbgate::app {
namespace {

${arrays}
constexpr PageFile kFiles[] = {
${entries}};

}  // namespace

std::span<const PageFile> page_files() { return kFiles; }

}  // namespace mbgate::app
")
