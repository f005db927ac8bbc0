// SPDX-License-Identifier: Apache-2.0
#include "ctl/trace/bus_packets.hpp"

#include <algorithm>
#include <string_view>

#include "ctl/trace/trace_lines.hpp"
#include "modbus/mbap.hpp"
#include "modbus/rtu.hpp"

namespace mbgate::ctl {
namespace {

/// Which side a frame is from. Wireshark tells a request from a response by its ports.
enum class Side : std::uint8_t { gateway, device, unknown };

/// The port of the device's side. That of RTU is not 502: there the clients' side is, and who tells
/// Wireshark that its RTU is at a port takes this port from Modbus TCP.
constexpr std::uint16_t port_of_device(std::string_view dissector) {
  return dissector == "mbtcp" ? 502 : 20502;
}
constexpr std::uint16_t kGatewayPort = 50000;

void append_tag(ByteString& bytes, std::uint16_t tag, modbus::Bytes value) {
  const std::size_t padded = (value.size() + 3) / 4 * 4;
  const std::uint8_t head[] = {static_cast<std::uint8_t>(tag >> 8U), static_cast<std::uint8_t>(tag),
                               static_cast<std::uint8_t>(padded >> 8U),
                               static_cast<std::uint8_t>(padded)};
  bytes.insert(bytes.end(), std::begin(head), std::end(head));
  bytes.insert(bytes.end(), value.begin(), value.end());
  bytes.resize(bytes.size() + padded - value.size());
}

void append_tag(ByteString& bytes, std::uint16_t tag, std::uint16_t value) {
  const std::uint8_t octets[] = {0, 0, static_cast<std::uint8_t>(value >> 8U),
                                 static_cast<std::uint8_t>(value)};
  append_tag(bytes, tag, octets);
}

/// The tags of Wireshark's wsutil/exported_pdu_tlvs.h, then the bytes.
ByteString upper_pdu(std::string_view dissector, Side side, modbus::Bytes bytes) {
  constexpr std::uint16_t kEnd = 0;
  constexpr std::uint16_t kDissector = 12;
  constexpr std::uint16_t kPortType = 24;
  constexpr std::uint16_t kSourcePort = 25;
  constexpr std::uint16_t kDestinationPort = 26;
  constexpr std::uint16_t kTcpPorts = 2;
  ByteString pdu;
  append_tag(pdu, kDissector, ByteString(dissector.begin(), dissector.end()));
  if (side != Side::unknown) {
    const bool is_gateway = side == Side::gateway;
    const std::uint16_t device_port = port_of_device(dissector);
    append_tag(pdu, kPortType, kTcpPorts);
    append_tag(pdu, kSourcePort, is_gateway ? kGatewayPort : device_port);
    append_tag(pdu, kDestinationPort, is_gateway ? device_port : kGatewayPort);
  }
  append_tag(pdu, kEnd, modbus::Bytes());
  pdu.insert(pdu.end(), bytes.begin(), bytes.end());
  return pdu;
}

/// Is it exactly one good frame that Wireshark has a dissector for? It has none for ASCII.
bool is_good_frame(TracedFraming framing, modbus::Bytes bytes) {
  switch (framing) {
    case TracedFraming::rtu: return modbus::decode_rtu(bytes).has_value();
    case TracedFraming::ascii: return false;
    case TracedFraming::tcp: {
      const modbus::MbapScan scan = modbus::scan_mbap(bytes);
      const auto* frame = std::get_if<modbus::MbapFrame>(&scan);
      return frame != nullptr && frame->size == bytes.size();
    }
  }
  return false;
}

/// The frame around the PDU that was taken, as it came.
ByteString taken_frame(const TracedFrame& frame) {
  const auto pdu = frame.response ? modbus::Pdu::from(*frame.response) : std::nullopt;
  ByteString taken;
  if (pdu && frame.framing == TracedFraming::rtu) {
    const modbus::RtuBytes bytes = modbus::encode_rtu(frame.address, *pdu);
    taken.assign(bytes.begin(), bytes.end());
  } else if (pdu && frame.framing == TracedFraming::tcp && frame.sent->raw.bytes.size() >= 2) {
    const modbus::MbapHeader header{modbus::load_be16(frame.sent->raw.bytes, 0), frame.address};
    const modbus::MbapBytes bytes = modbus::encode({header, *pdu});
    taken.assign(bytes.begin(), bytes.end());
  }
  return taken;
}

/// From heard bytes to packets.
class HeardPackets {
 public:
  explicit HeardPackets(const TracedFrame& frame) : frame_(frame), all_(all_heard(frame)) {}

  std::vector<CapturedPacket> take() {
    std::size_t begin = 0;
    std::size_t end = all_.size();
    if (frame_.sent && is_echo()) {
      begin = frame_.sent->raw.bytes.size();
      add_bytes(0, begin, "the same as was sent: the line hears itself");
    }
    const ByteString taken = taken_frame(frame_);
    const auto rest = all_.begin() + static_cast<std::ptrdiff_t>(begin);
    const auto found = taken.empty()
                           ? std::ranges::subrange(all_.end(), all_.end())
                           : std::ranges::find_end(rest, all_.end(), taken.begin(), taken.end());
    if (!found.empty()) {
      end = static_cast<std::size_t>(found.begin() - all_.begin());
      add_others(begin, end);
      add_frame(end, end + taken.size(), Side::device);
      begin = end + taken.size();
      end = all_.size();
    }
    add_others(begin, end);
    return std::move(packets_);
  }

 private:
  /// A response may look like its request; then something must come behind the echo.
  [[nodiscard]] bool is_echo() const {
    const ByteString& sent = frame_.sent->raw.bytes;
    const bool begins = !sent.empty() && all_.size() >= sent.size() &&
                        std::equal(sent.begin(), sent.end(), all_.begin());
    return begins && frame_.framing != TracedFraming::tcp &&
           (all_.size() > sent.size() || !frame_.response);
  }

  /// When the byte came that has this place among all.
  [[nodiscard]] TraceInstant instant_of(std::size_t place) const {
    std::size_t end = 0;
    for (const TracedBytes& part : frame_.heard) {
      end += part.bytes.size();
      if (place < end) {
        return part.at;
      }
    }
    return frame_.ended_at;
  }

  /// Where the part ends that this byte came in.
  [[nodiscard]] std::size_t part_end(std::size_t place) const {
    std::size_t end = 0;
    for (const TracedBytes& part : frame_.heard) {
      end += part.bytes.size();
      if (place < end) {
        break;
      }
    }
    return end;
  }

  [[nodiscard]] modbus::Bytes piece(std::size_t begin, std::size_t end) const {
    return modbus::Bytes(all_).subspan(begin, end - begin);
  }

  void add(std::size_t begin, ByteString bytes, std::string comment) {
    packets_.push_back({instant_of(begin), Heading::inbound, std::move(bytes), std::move(comment)});
  }
  void add_frame(std::size_t begin, std::size_t end, Side side) {
    const char* const dissector = frame_.framing == TracedFraming::tcp ? "mbtcp" : "mbrtu";
    add(begin, upper_pdu(dissector, side, piece(begin, end)), {});
  }
  void add_bytes(std::size_t begin, std::size_t end, std::string comment) {
    if (begin < end) {
      add(begin, upper_pdu("data", Side::unknown, piece(begin, end)), std::move(comment));
    }
  }

  /// Where a good frame ends that begins here, at the end of a part; or 0.
  [[nodiscard]] std::size_t good_end(std::size_t begin, std::size_t limit) const {
    for (std::size_t end = begin; end < limit;) {
      end = std::min(part_end(end), limit);
      if (end - begin > modbus::kMaxMbapAduSize) {
        return 0;
      }
      if (is_good_frame(frame_.framing, piece(begin, end))) {
        return end;
      }
    }
    return 0;
  }

  /// What is not the response: frames of others, which come in parts of their own, and bytes.
  void add_others(std::size_t begin, std::size_t limit) {
    const std::string comment = frame_.response && frame_.framing != TracedFraming::ascii
                                    ? "no part of the response"
                                    : frame_.heard_text;
    std::size_t bytes_from = begin;
    for (std::size_t at = begin; at < limit;) {
      if (const std::size_t end = good_end(at, limit); end != 0) {
        add_bytes(bytes_from, at, comment);
        add_frame(at, end, frame_.sent ? Side::device : Side::unknown);
        at = bytes_from = end;
      } else {
        at = std::min(part_end(at), limit);
      }
    }
    add_bytes(bytes_from, limit, comment);
  }

  const TracedFrame& frame_;
  ByteString all_;
  std::vector<CapturedPacket> packets_;
};

CapturedPacket sent_packet(const TracedFrame& frame) {
  const TracedAdu& sent = *frame.sent;
  if (!is_good_frame(frame.framing, sent.raw.bytes)) {
    return {sent.raw.at, Heading::outbound, upper_pdu("data", Side::unknown, sent.raw.bytes),
            sent.text};
  }
  const char* const dissector = frame.framing == TracedFraming::tcp ? "mbtcp" : "mbrtu";
  return {sent.raw.at, Heading::outbound, upper_pdu(dissector, Side::gateway, sent.raw.bytes), {}};
}

}  // namespace

std::vector<CapturedPacket> bus_packets(const TracedFrame& frame) {
  std::vector<CapturedPacket> packets;
  if (frame.sent) {
    packets.push_back(sent_packet(frame));
  }
  for (CapturedPacket& packet : HeardPackets(frame).take()) {
    packets.push_back(std::move(packet));
  }
  return packets;
}

}  // namespace mbgate::ctl
