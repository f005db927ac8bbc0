// SPDX-License-Identifier: Apache-2.0
// The files of the status page, as they are in this folder. CMake puts them into the program
// (embed.cmake), so that it needs no folder of its own when it runs.
#pragma once

#include <span>
#include <string_view>

namespace mbgate::app {

struct PageFile {
  std::string_view name;  ///< "page.css"
  std::string_view content;
  std::string_view hash;  ///< of its content: another one after any change
};

std::span<const PageFile> page_files();

}  // namespace mbgate::app
