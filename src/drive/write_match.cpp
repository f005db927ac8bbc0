// SPDX-License-Identifier: Apache-2.0
#include "drive/write_match.hpp"

#include "drive/register_range.hpp"

namespace mbgate::drive {

bool writes(const modbus::Request& request, const WriteMatch& match) {
  const auto& field = request.writes();
  if (!field || !contains(field->range, match.table, match.address)) {
    return false;
  }
  const auto written = request.written(match.address);
  return written && match.fits(*written);
}

bool writes_only(const modbus::Request& request, const WriteMatch& match) {
  return !request.reads() && writes(request, match) &&
         request.writes()->range.first == match.address &&
         request.writes()->range.count <= 1U + match.parameters;
}

}  // namespace mbgate::drive
