#include "command/version.h"

#include "commit.h"

namespace command {

const char* version() { return KERBSTONE_VERSION " (" KERBSTONE_COMMIT ")"; }

}  // namespace command
