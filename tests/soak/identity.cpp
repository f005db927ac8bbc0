// SPDX-License-Identifier: Apache-2.0
#include "soak/identity.hpp"

#include "soak/pdus.hpp"

namespace mbgate::soak {
namespace {

using spec::Octets;
using Word = std::function<unsigned(unsigned, std::size_t)>;

void append(Octets& answer, unsigned from, unsigned count, const Word& word) {
  for (unsigned at = 0; at < count; ++at) {
    const unsigned value = word(from + at, answer.size());
    answer.push_back(low(value >> 8U));
    answer.push_back(low(value));
  }
}

// 6.21: each object has a number and a length.
Octets objects(unsigned count, const Word& word) {
  Octets answer{0x2B, 0x0E, 0x01, 0x01, 0, 0, low(count)};
  for (unsigned at = 0; at < count; ++at) {
    answer.push_back(low(at));
    answer.push_back(2);
    append(answer, at, 1, word);
  }
  return answer;
}

}  // namespace

bool asks_identity(spec::Bytes request) {
  const std::uint8_t function = request[0];
  return function == 0x07 || function == 0x0B || function == 0x0C || function == 0x11 ||
         function == 0x14 || function == 0x18 || (function == 0x2B && !spec::is_opaque(request));
}

unsigned shown_by(spec::Bytes request, unsigned otherwise) {
  constexpr std::size_t kRecordLength = 7;
  switch (request[0]) {
    case 0x07: return 1;
    case 0x0B: return 2;
    case 0x14: return spec::word_at(request, kRecordLength);
    default: return otherwise;
  }
}

Octets identity_answer(spec::Bytes request, unsigned count, const Word& word) {
  const unsigned size = 2 * count;
  switch (request[0]) {
    case 0x07: {  // 6.7: one byte; the low one
      Octets answer{0x07};
      append(answer, 0, 1, word);
      answer.erase(answer.begin() + 1);
      return answer;
    }
    case 0x0B: {  // 6.9
      Octets answer{0x0B};
      append(answer, 0, 2, word);
      return answer;
    }
    case 0x14: {  // 6.14: of one group
      Octets answer{0x14, low(size + 2), low(size + 1), 6};
      append(answer, spec::word_at(request, 5), count, word);
      return answer;
    }
    case 0x18: {  // 6.18
      Octets answer{0x18, 0, low(size + 2), 0, low(count)};
      append(answer, spec::word_at(request, 1), count, word);
      return answer;
    }
    case 0x2B: return objects(count, word);
    default: {  // 6.10, 6.13
      Octets answer{request[0], low(size)};
      append(answer, 0, count, word);
      return answer;
    }
  }
}

}  // namespace mbgate::soak
