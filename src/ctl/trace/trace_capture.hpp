// SPDX-License-Identifier: Apache-2.0
// A trace as the bytes of a capture file (pcapng): the clients' side as TCP segments that are made
// up around what was said, and an interface for each bus. No file is touched here.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "ctl/trace/pcapng.hpp"

namespace mbgate::ctl {

class TraceCapture {
 public:
  /// How much is kept, for a trace of weeks.
  static constexpr std::size_t kMostConversations = 65536;  ///< then sequence numbers begin anew
  static constexpr std::size_t kMostShared = 256;           ///< frames that several requests share

  /// The beginning of the file.
  static ByteString start();
  /// What the record adds to it: whole blocks, the packets in the order of their instants. Comments
  /// say what has failed, and what was not kept.
  ByteString add(const TraceEvent& event);
  /// Records are missing before the next one: its first packet says so.
  void note_lost(std::uint64_t lost) { lost_ += lost; }

 private:
  /// Who talks: the octets of the client's address, and its port.
  using Conversation = std::pair<ByteString, std::uint16_t>;
  struct Streams {
    std::uint32_t of_client = 1;  ///< the next sequence number
    std::uint32_t of_gateway = 1;
  };
  struct Placed {
    std::uint32_t interface;
    CapturedPacket packet;
  };

  /// A frame that several requests share.
  struct Shared {
    std::string bus;
    TracedBytes sent;
  };

  void add_request(const TracedRequest& asked, const std::string& comment,
                   std::vector<Placed>& packets);
  void add_frame(const TracedFrame& frame, std::vector<Placed>& packets, ByteString& blocks);
  [[nodiscard]] bool was_added(const TracedFrame& frame);
  std::uint32_t interface_of(const std::string& bus, ByteString& blocks);

  std::map<std::string, std::uint32_t> buses_;
  std::map<Conversation, Streams> conversations_;
  std::deque<Shared> shared_;
  std::uint64_t lost_ = 0;
};

// What went over a line, as packets for Wireshark: good frames for the dissector that knows them,
// all else as bytes with a comment that says what they are.

/// In the order of the line. The bytes are those of LinkType::upper_pdu. What is no good frame is
/// never given to a dissector of Modbus, which would call it malformed.
std::vector<CapturedPacket> bus_packets(const TracedFrame& frame);

}  // namespace mbgate::ctl
