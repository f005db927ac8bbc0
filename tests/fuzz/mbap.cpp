// SPDX-License-Identifier: Apache-2.0
// A stream of MBAP ADUs means the same however it is split. The first byte says how.
#include "modbus/mbap.hpp"

#include <vector>

#include "fuzz/fuzz.hpp"

namespace mbgate::fuzz::mbap_target {
namespace {

using Stream = std::vector<std::uint8_t>;

/// What was found, byte for byte: a mark, and the whole ADU.
struct Found {
  Stream bytes;
  bool lost = false;
};

void add(Found& found, std::uint8_t mark, modbus::Bytes adu) {
  found.bytes.push_back(mark);
  found.bytes.insert(found.bytes.end(), adu.begin(), adu.end());
}

/// Takes off the front of the stream what is complete.
void take(Stream& stream, Found& found) {
  while (!found.lost) {
    const modbus::MbapScan scan = modbus::scan_mbap(stream);
    std::size_t size = 0;
    if (const auto* frame = std::get_if<modbus::MbapFrame>(&scan)) {
      size = frame->size;
      require(size <= stream.size() && size <= modbus::kMaxMbapAduSize, "a frame is in the stream");
      const auto encoded = modbus::encode(frame->adu);
      require(std::equal(encoded.begin(), encoded.end(), stream.begin(),
                         stream.begin() + static_cast<std::ptrdiff_t>(size)),
              "a frame is what it was made of");
      add(found, 'f', modbus::Bytes(stream).first(size));
    } else if (const auto* foreign = std::get_if<modbus::MbapForeign>(&scan)) {
      size = foreign->size;
      require(size <= stream.size() && foreign->protocol != 0, "a foreign ADU is in the stream");
      add(found, 'x', modbus::Bytes(stream).first(size));
    } else if (const auto* lost = std::get_if<modbus::MbapLost>(&scan)) {
      require(lost->length < 2 || lost->length > 254, "a good length is not lost");
      found.lost = true;
      return;
    } else {
      return;
    }
    require(size > 0, "the stream goes on");
    stream.erase(stream.begin(), stream.begin() + static_cast<std::ptrdiff_t>(size));
  }
}

Found in_pieces(modbus::Bytes stream, std::size_t piece) {
  Found found;
  Stream waiting;
  while (!stream.empty()) {
    const modbus::Bytes next = stream.first(std::min(piece, stream.size()));
    stream = stream.subspan(next.size());
    waiting.insert(waiting.end(), next.begin(), next.end());
    take(waiting, found);
  }
  return found;
}

}  // namespace

MBGATE_FUZZ_TARGET(mbap) {
  Script script(data, size);
  const std::size_t piece = 1U + script.byte();
  const auto stream = script.rest();
  const Found whole = in_pieces(stream, stream.size() + 1);
  for (const std::size_t split : {std::size_t{1}, piece}) {
    const Found found = in_pieces(stream, split);
    require(found.bytes == whole.bytes && found.lost == whole.lost, "pieces mean the same");
  }
  mbgate::modbus::looks_like_rtu(stream);
  return 0;
}

}  // namespace mbgate::fuzz::mbap_target
