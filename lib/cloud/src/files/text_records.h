// Tables of numbers in lines: their columns, and their values.
#pragma once

#include <string>
#include <string_view>

#include "emitter.h"
#include "records.h"

namespace cloud {

/// The number at `here`, moved behind it; NaN for "nan"; false where there is none.
bool number_at(const char*& here, const char* end, double& value);

/// Columns by a header line of names, or x y z [intensity] without one.
Records xyz_records(std::string_view bytes, const std::string& name, CloudReadReport& report);

/// So many points at once. Throws Error naming the line that is no row of the table.
void read_text(const Records& records, const std::string& name, std::size_t chunk_points,
               Emitter& emit);

}  // namespace cloud
