// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <iterator>
#include <string_view>

#include "ctl/trace/trace_capture.hpp"
#include "ctl/trace/trace_event.hpp"
#include "modbus/frames.hpp"
#include "modbus/mbap.hpp"
#include "modbus/request.hpp"
#include "modbus/response.hpp"

namespace mbgate::ctl {
namespace {

/// Which side a frame is from: that of the gateway, and of other clients of the line, or that of a
/// device. Wireshark tells a request from a response by its ports.
enum class Side : std::uint8_t { client, device, unknown };

const char* dissector_of(TracedFraming framing) {
  return framing == TracedFraming::tcp ? "mbtcp" : "mbrtu";
}

/// The port of the device's side. That of RTU is not 502: there the clients' side is, and who tells
/// Wireshark that its RTU is at a port takes this port from Modbus TCP.
constexpr std::uint16_t port_of_device(std::string_view dissector) {
  return dissector == "mbtcp" ? 502 : 20502;
}
constexpr std::uint16_t kClientPort = 50000;

void append_tag(ByteString& bytes, std::uint16_t tag, modbus::Bytes value) {
  const std::size_t padded = (value.size() + 3) / 4 * 4;
  std::array<std::uint8_t, 4> head{};
  modbus::store_be16(head, 0, tag);
  modbus::store_be16(head, 2, static_cast<std::uint16_t>(padded));
  append(bytes, head);
  append(bytes, value);
  bytes.resize(bytes.size() + padded - value.size());
}

void append_tag(ByteString& bytes, std::uint16_t tag, std::uint16_t value) {
  std::array<std::uint8_t, 4> octets{};
  modbus::store_be16(octets, 2, value);
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
    const bool is_client = side == Side::client;
    const std::uint16_t device_port = port_of_device(dissector);
    append_tag(pdu, kPortType, kTcpPorts);
    append_tag(pdu, kSourcePort, is_client ? kClientPort : device_port);
    append_tag(pdu, kDestinationPort, is_client ? device_port : kClientPort);
  }
  append_tag(pdu, kEnd, modbus::Bytes());
  append(pdu, bytes);
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

/// Whose frame it is that was heard on a serial line and not taken, by its length. A write and the
/// answer to it look the same.
Side side_of(const modbus::Pdu& pdu) {
  const auto is_whole = [&](const modbus::PduLength& length) {
    return length.kind == modbus::PduLength::Kind::known && length.bytes == pdu.size();
  };
  const bool may_be_response = is_whole(modbus::response_length(pdu.bytes()));
  const bool may_be_request =
      is_whole(modbus::request_length(pdu.bytes())) && modbus::Request::parse(pdu);
  if (may_be_response == may_be_request) {
    return Side::unknown;
  }
  return may_be_response ? Side::device : Side::client;
}

Side side_of(TracedFraming framing, modbus::Bytes good_frame) {
  if (framing == TracedFraming::tcp) {
    return Side::device;  // a connection has only one other end
  }
  const auto adu = modbus::decode_rtu(good_frame);
  return adu ? side_of(adu->pdu) : Side::unknown;
}

/// The frame around the PDU that was taken, as it came.
ByteString taken_frame(const TracedFrame& frame) {
  const auto pdu = frame.response ? modbus::Pdu::from(*frame.response) : std::nullopt;
  if (!pdu || !frame.sent) {
    return {};
  }
  const auto copy = [](const auto& bytes) { return ByteString(bytes.begin(), bytes.end()); };
  switch (frame.framing) {
    case TracedFraming::rtu: return copy(modbus::encode_rtu(frame.address, *pdu));
    case TracedFraming::ascii: return copy(modbus::encode_ascii(frame.address, *pdu));
    case TracedFraming::tcp: break;
  }
  if (frame.sent->raw.bytes.size() < 2) {
    return {};
  }
  const modbus::MbapHeader header{modbus::load_be16(frame.sent->raw.bytes, 0), frame.address};
  return copy(modbus::encode({header, *pdu}));
}

/// From heard bytes to packets.
class HeardPackets {
 public:
  explicit HeardPackets(const TracedFrame& frame)
      : frame_(frame), all_(all_heard(frame)), taken_(taken_frame(frame)) {}

  std::vector<CapturedPacket> take() {
    std::size_t begin = 0;
    if (frame_.sent && is_echo()) {
      begin = frame_.sent->raw.bytes.size();
      add_bytes(0, begin, "the same bytes as sent: the adapter receives what it sends");
    }
    if (const auto found = taken_from(begin)) {
      add_others(begin, *found);
      begin = *found + taken_.size();
      if (frame_.framing == TracedFraming::ascii) {
        add_bytes(*found, begin, frame_.heard_text);
      } else {
        add_frame(*found, begin, Side::device, {});
      }
    }
    add_others(begin, all_.size());
    return std::move(packets_);
  }

 private:
  /// Where the frame that was taken begins, the last one from this place on.
  [[nodiscard]] std::optional<std::size_t> taken_from(std::size_t place) const {
    const modbus::Bytes rest = modbus::Bytes(all_).subspan(place);
    const auto found = std::ranges::find_end(rest, taken_);
    return taken_.empty() || found.empty()
               ? std::nullopt
               : std::optional(place + static_cast<std::size_t>(found.begin() - rest.begin()));
  }

  /// A response may look like its request; then the response must come behind the echo.
  [[nodiscard]] bool is_echo() const {
    const ByteString& sent = frame_.sent->raw.bytes;
    const bool begins = !sent.empty() && all_.size() >= sent.size() &&
                        std::equal(sent.begin(), sent.end(), all_.begin());
    return begins && frame_.framing != TracedFraming::tcp &&
           (!frame_.response || taken_from(sent.size()));
  }

  struct Part {
    TraceInstant at;  ///< when it came
    std::size_t end;  ///< its place among all bytes
  };
  /// The part with the byte that has this place among all.
  [[nodiscard]] Part part_of(std::size_t place) const {
    std::size_t end = 0;
    for (const TracedBytes& part : frame_.heard) {
      end += part.bytes.size();
      if (place < end) {
        return {part.at, end};
      }
    }
    return {frame_.ended_at, end};
  }

  [[nodiscard]] modbus::Bytes piece(std::size_t begin, std::size_t end) const {
    return modbus::Bytes(all_).subspan(begin, end - begin);
  }

  void add(std::size_t begin, ByteString bytes, std::string comment) {
    packets_.push_back({part_of(begin).at, Heading::inbound, std::move(bytes), std::move(comment)});
  }
  void add_frame(std::size_t begin, std::size_t end, Side side, std::string comment) {
    add(begin, upper_pdu(dissector_of(frame_.framing), side, piece(begin, end)),
        std::move(comment));
  }
  void add_bytes(std::size_t begin, std::size_t end, std::string comment) {
    if (begin < end) {
      add(begin, upper_pdu("data", Side::unknown, piece(begin, end)), std::move(comment));
    }
  }

  /// Where a good frame ends that begins here, at the end of a part; or 0.
  [[nodiscard]] std::size_t good_end(std::size_t begin, std::size_t limit) const {
    for (std::size_t end = begin; end < limit;) {
      end = std::min(part_of(end).end, limit);
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
    const std::string comment = taken_from(0) ? "no part of the response" : frame_.heard_text;
    std::size_t bytes_from = begin;
    for (std::size_t at = begin; at < limit;) {
      if (const std::size_t end = good_end(at, limit); end != 0) {
        add_bytes(bytes_from, at, comment);
        add_frame(at, end, side_of(frame_.framing, piece(at, end)),
                  frame_.sent ? "not the response" : "");
        at = bytes_from = end;
      } else {
        at = std::min(part_of(at).end, limit);
      }
    }
    add_bytes(bytes_from, limit, comment);
  }

  const TracedFrame& frame_;
  ByteString all_;
  ByteString taken_;
  std::vector<CapturedPacket> packets_;
};

CapturedPacket sent_packet(const TracedFrame& frame) {
  const auto& [raw, text] = *frame.sent;
  if (!is_good_frame(frame.framing, raw.bytes)) {
    return {raw.at, Heading::outbound, upper_pdu("data", Side::unknown, raw.bytes), text};
  }
  return {raw.at, Heading::outbound,
          upper_pdu(dissector_of(frame.framing), Side::client, raw.bytes)};
}

}  // namespace

std::vector<CapturedPacket> bus_packets(const TracedFrame& frame) {
  std::vector<CapturedPacket> packets;
  if (frame.sent) {
    packets.push_back(sent_packet(frame));
  }
  std::ranges::move(HeardPackets(frame).take(), std::back_inserter(packets));
  return packets;
}

}  // namespace mbgate::ctl
