// SPDX-License-Identifier: Apache-2.0
#include "soak/own_identity.hpp"

#include <algorithm>
#include <vector>

namespace mbgate::soak {
namespace {

constexpr std::size_t kHead = 7;  // function, MEI type, code, conformity, more, next, count
constexpr std::uint8_t kOne = 4;  // the code that asks for one object
constexpr std::uint8_t kLastBasic = 2;

bool asks_for_objects(spec::Bytes request) { return request.size() == 4 && request[0] == 0x2B; }

}  // namespace

std::string objection_to_identity(spec::Bytes request, spec::Bytes answer) {
  if (!asks_for_objects(request)) {
    return "";
  }
  const std::uint8_t code = request[2];
  const std::uint8_t first = request[3];
  if (code < 1 || code > kOne) {
    return "an answer to a code that there is not";
  }
  if (answer.size() < kHead || answer[1] != 0x0E || answer[2] != code) {
    return "no head";
  }
  std::vector<std::uint8_t> objects;
  for (std::size_t at = kHead; at + 1 < answer.size(); at += 2U + answer[at + 1]) {
    objects.push_back(answer[at]);
  }
  if (objects.empty() || objects.size() != answer[kHead - 1] ||
      !std::ranges::is_sorted(objects, std::ranges::less_equal())) {
    return "objects out of order";
  }
  if (code == kOne) {
    return objects.size() == 1 && objects.front() == first ? "" : "another object";
  }
  if (code == 1 && objects.back() > kLastBasic) {
    return "more than the basic objects";
  }
  const bool goes_on = objects.front() == first && (code > 1 || first <= kLastBasic);
  const bool restarts = objects.front() == 0 && std::ranges::find(objects, first) == objects.end();
  return goes_on || restarts ? "" : "no stream";
}

bool may_refuse_identity(spec::Bytes request, std::uint8_t exception) {
  if (!asks_for_objects(request)) {
    return true;
  }
  const std::uint8_t code = request[2];
  switch (exception) {
    case 0x02: return code == kOne;
    case 0x03: return code < 1 || code > kOne;
    default: return true;
  }
}

}  // namespace mbgate::soak
