// SPDX-License-Identifier: Apache-2.0
#include "ctl/trace/trace_capture.hpp"

#include <algorithm>
#include <fmt/core.h>
#include <stdexcept>

#include "ctl/trace/trace_event.hpp"

namespace mbgate::ctl {
namespace {

constexpr std::uint32_t kClients = 0;          // the interface
constexpr std::uint16_t kModbusTcpPort = 502;  // where Wireshark looks for Modbus

/// An address for the gateway that is nobody's: those of documentation (RFC 5737, RFC 3849). The
/// trace does not say which of its own addresses a client has used.
TcpEndpoint gateway_towards(const ByteString& client) {
  const bool is_v4 = client.size() == 4;
  return {*ip_octets(is_v4 ? "192.0.2.1" : "2001:db8::1"), kModbusTcpPort};
}

/// A port that a program has; the number of its connection tells it from others of the address.
std::uint16_t port_of(std::uint64_t connection) {
  constexpr std::uint64_t kFirst = 1024;
  constexpr std::uint64_t kPorts = 65536 - kFirst;
  return static_cast<std::uint16_t>(kFirst + connection % kPorts);
}

/// Two instants of the same. Each batch is told by the clock of its own moment, so they may differ
/// a little; and a frame of the same bytes that is sent again comes later than this.
bool is_same(TraceInstant one, TraceInstant other) {
  constexpr std::chrono::milliseconds kTolerance{1};
  return std::chrono::abs(one - other) <= kTolerance;
}

std::string failed_comment(const std::string& failure) {
  return failure.empty() ? failure : "failed: " + failure;
}

void add_line(std::string& comment, const std::string& line) {
  comment += (comment.empty() ? "" : "\n") + line;
}

}  // namespace

ByteString TraceCapture::start() {
  ByteString blocks = section_block("mbgatectl trace");
  append(blocks,
         interface_block(
             LinkType::raw_ip, "clients",
             "messages between clients and the gateway; its address and all ports are made up"));
  return blocks;
}

ByteString TraceCapture::add(const TraceEvent& event) {
  ByteString blocks;
  std::vector<Placed> packets;
  if (event.asked) {
    add_request(*event.asked, failed_comment(request_failure(event)), packets);
  }
  for (const TracedFrame& frame : event.wire) {
    add_frame(frame, packets, blocks);
  }
  std::ranges::stable_sort(packets, {}, [](const Placed& it) { return it.packet.at; });
  if (!packets.empty() && lost_ > 0) {
    std::string& first = packets.front().packet.comment;
    std::string missing = missing_records(std::exchange(lost_, 0));
    if (!first.empty()) {
      add_line(missing, first);
    }
    first = std::move(missing);
  }
  if (!packets.empty() && event.wire_not_kept > 0) {
    add_line(packets.back().packet.comment, and_more(event.wire_not_kept, "frame"));
  }
  for (const Placed& it : packets) {
    append(blocks, packet_block(it.interface, it.packet));
  }
  return blocks;
}

void TraceCapture::add_request(const TracedRequest& asked, const std::string& comment,
                               std::vector<Placed>& packets) {
  const auto address = ip_octets(asked.client);
  if (!address) {
    throw std::invalid_argument(fmt::format("\"{}\" is not an IP address", asked.client));
  }
  if (conversations_.size() >= kMostConversations) {
    conversations_.clear();
  }
  const TcpEndpoint client{*address, port_of(asked.connection)};
  const TcpEndpoint gateway = gateway_towards(*address);
  Streams& streams = conversations_[{client.address, client.port}];
  const auto add = [&](const TracedBytes& said, Heading heading, const TcpEndpoint& from,
                       const TcpEndpoint& to, TcpPlace place) {
    packets.push_back(
        {kClients, {said.at, heading, tcp_segment(from, to, place, said.bytes), comment}});
    return place.sequence + static_cast<std::uint32_t>(said.bytes.size());
  };
  streams.of_client = add(asked.request.raw, Heading::inbound, client, gateway,
                          {streams.of_client, streams.of_gateway});
  if (asked.answer) {
    streams.of_gateway = add(asked.answer->raw, Heading::outbound, gateway, client,
                             {streams.of_gateway, streams.of_client});
  }
}

void TraceCapture::add_frame(const TracedFrame& frame, std::vector<Placed>& packets,
                             ByteString& blocks) {
  if (was_added(frame)) {
    return;
  }
  const std::uint32_t interface = interface_of(frame.bus, blocks);
  const std::string failure = failed_comment(failure_of(frame));
  std::vector<CapturedPacket> of_frame = bus_packets(frame);
  if (!of_frame.empty() && frame.not_kept > 0) {
    add_line(of_frame.back().comment, and_more(frame.not_kept, "byte"));
  }
  for (CapturedPacket& packet : of_frame) {
    if (packet.heading == Heading::outbound && !failure.empty()) {
      add_line(packet.comment, failure);
    }
    packets.push_back({interface, std::move(packet)});
  }
}

/// A frame that answers several requests comes with each of them.
bool TraceCapture::was_added(const TracedFrame& frame) {
  if (!frame.sent || frame.shared_by < 2) {
    return false;
  }
  const TracedBytes& sent = frame.sent->raw;
  const bool is_known = std::ranges::any_of(shared_, [&](const Shared& it) {
    return it.bus == frame.bus && it.sent.bytes == sent.bytes && is_same(it.sent.at, sent.at);
  });
  if (is_known) {
    return true;
  }
  shared_.push_back({frame.bus, sent});
  if (shared_.size() > kMostShared) {
    shared_.pop_front();
  }
  return false;
}

std::uint32_t TraceCapture::interface_of(const std::string& bus, ByteString& blocks) {
  const auto number = static_cast<std::uint32_t>(kClients + 1 + buses_.size());
  const auto [it, is_new] = buses_.try_emplace(bus, number);
  if (is_new) {
    append(blocks, interface_block(LinkType::upper_pdu, bus, "the frames on this bus"));
  }
  return it->second;
}

}  // namespace mbgate::ctl
