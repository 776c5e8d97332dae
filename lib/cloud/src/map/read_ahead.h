// Scans are read and decoded while the points before are worked on.
#pragma once

#include "cloud/read_cloud.h"

namespace cloud {

/// The same chunks in the same order, from a thread of their own that is one chunk ahead; with one
/// thread the source as it is. The source's exceptions are thrown where its chunks are taken.
CloudSource read_ahead(CloudSource source, unsigned threads);

}  // namespace cloud
