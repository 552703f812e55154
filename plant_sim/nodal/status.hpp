#pragma once

namespace stillframe::nodal {

enum class Status { ok, position_not_found, matrix_singular, too_many_steps, failed };

}  // namespace stillframe::nodal
