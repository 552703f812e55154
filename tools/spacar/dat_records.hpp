#pragma once

#include <optional>
#include <string>
#include <vector>

namespace stillframe::tools::spacar {

/// One line of a .dat file: its keyword in capitals, and what stands behind it.
struct Record {
  int line = 0;
  int block = 0;  ///< 0 kinematics, 1 dynamics, 2 linearisation: HALT opens the next
  std::string keyword;
  std::vector<std::string> words;
};

/// A whole file: blocks end with END, another block follows after HALT, the file ends with END
/// twice. What stands behind that is of Spavisual, which draws.
struct DatFile {
  std::string name;
  std::vector<Record> records;
  int first_line_of_pictures = 0;  ///< 0: there is none
};

/// Errors: InputError of a file without its END, or with something between END and HALT.
DatFile parse_dat(const std::vector<std::string>& lines, const std::string& name);

/// The word as a whole number above 0, or as a finite number below 1e30; FORTRAN's D is an E.
/// Errors: InputError that names line and keyword.
int whole_number(const DatFile& file, const Record& record, std::size_t i);
double real_number(const DatFile& file, const Record& record, std::size_t i);

/// The numbers from the i-th word on.
std::vector<double> real_numbers(const DatFile& file, const Record& record, std::size_t from);

/// Errors: InputError if the record has fewer or more words.
void require_count(const DatFile& file, const Record& record, std::size_t least, std::size_t most,
                   const std::string& allowed);

}  // namespace stillframe::tools::spacar
