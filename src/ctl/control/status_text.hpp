// SPDX-License-Identifier: Apache-2.0
// The status of mbgated for people: faults, then a table each of lines, drives and clients.
#pragma once

#include <boost/json/object.hpp>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace mbgate::ctl {

/// `status`: what GET /api/v1/status answers. Throws std::exception if it is something else.
std::string status_text(const boost::json::object& status);

/// A text as a window of the terminal can show it: at most `rows` lines, none longer than `columns`
/// characters. Sentences go on in the next line; rows of tables, which have two blanks between
/// their columns, are cut. What does not fit below is left out, and the last line says so. A
/// character that would move the cursor becomes "?".
std::vector<std::string> page(std::string_view text, std::size_t rows, std::size_t columns);

}  // namespace mbgate::ctl
