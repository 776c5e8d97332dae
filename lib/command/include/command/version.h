#pragma once

namespace command {

/// The version and the commit that it was built from, e.g. "0.1.0 (7733d7bafd)"; "-dirty" follows
/// the commit of an edited checkout, "unknown" stands for it outside of a checkout.
const char* version();

}  // namespace command
