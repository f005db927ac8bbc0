// SPDX-License-Identifier: Apache-2.0
// The status of mbgated for people: faults, then a table each of lines, drives and clients.
#pragma once

#include <boost/json/object.hpp>
#include <string>

namespace mbgate::ctl {

/// `status`: what GET /api/v1/status answers. Throws std::exception if it is something else.
std::string status_text(const boost::json::object& status);

}  // namespace mbgate::ctl
