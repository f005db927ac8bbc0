// SPDX-License-Identifier: Apache-2.0
// `mbgatectl cert`: the certificates of a first plant.
#pragma once

#include <iosfwd>

#include "ctl/cert/cert_request.hpp"

namespace mbgate::ctl {

/// Makes, revokes or shows; prints to `out` what was made and where it goes, to `errors` why it was
/// not. Returns the exit status: kExitDone or kExitNotDone.
int carry_out_cert(const CertCommand& command, std::ostream& out, std::ostream& errors);

}  // namespace mbgate::ctl
