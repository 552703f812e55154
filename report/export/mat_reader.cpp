#include "report/export/mat_reader.hpp"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <optional>

#include "core/errors/input_error.hpp"
#include "core/files/utf8.hpp"

namespace stillframe::report {

namespace {

using Eigen::Index;

constexpr std::size_t header_size = 128;
constexpr std::size_t most_bytes = std::size_t{64} << 20;
constexpr int most_depth = 8;

/// What is wrong with a file; read_mat says whose.
struct Broken {
  std::string what;
};

/// Types of the parts of a variable.
constexpr std::uint32_t type_matrix = 14, type_compressed = 15;

/// Classes of variables.
enum class Class : std::uint32_t {
  cell = 1,
  structure = 2,
  object = 3,
  text = 4,
  sparse = 5,
  first_number = 6,
  last_number = 15
};

/// A part of a file and what is left behind it.
class Parts {
 public:
  explicit Parts(std::string_view bytes) : left_(bytes) {}

  struct Part {
    std::uint32_t type = 0;
    std::string_view data;
  };

  bool empty() const { return left_.empty(); }

  Part next() {
    const std::uint32_t first = word(0);
    if (first >> 16 != 0) {  // four bytes or less, in the place of their own length
      const std::size_t size = first >> 16;
      if (size > 4) throw Broken{"has a part whose size is not sound"};
      return take(first & 0xFFFF, 4, size, 8);
    }
    const std::size_t size = word(4);
    // Only what is compressed is not filled up to eight bytes; the last part may end early.
    const std::size_t filled = first == type_compressed ? size : (size + 7) / 8 * 8;
    return take(first, 8, size, std::min(8 + filled, left_.size()));
  }

 private:
  std::uint32_t word(std::size_t at) const {
    if (left_.size() < at + sizeof(std::uint32_t)) throw Broken{"ends within a part"};
    std::uint32_t value = 0;
    std::memcpy(&value, left_.data() + at, sizeof value);
    return value;
  }

  Part take(std::uint32_t type, std::size_t begin, std::size_t size, std::size_t total) {
    if (left_.size() < begin || left_.size() - begin < size || left_.size() < total) {
      throw Broken{"ends within a part"};
    }
    const Part part{type, left_.substr(begin, size)};
    left_.remove_prefix(total);
    return part;
  }

  std::string_view left_;
};

template <class T>
std::vector<double> numbers_as(std::string_view data) {
  if (data.size() % sizeof(T) != 0) throw Broken{"has numbers that end within one"};
  std::vector<double> values;
  values.reserve(data.size() / sizeof(T));
  for (std::size_t at = 0; at < data.size(); at += sizeof(T)) {
    T value{};
    std::memcpy(&value, data.data() + at, sizeof(T));
    values.push_back(static_cast<double>(value));
  }
  return values;
}

/// Numbers are stored in the smallest type that holds them, whatever class they are of.
std::vector<double> numbers(const Parts::Part& part) {
  switch (part.type) {
    case 1:
      return numbers_as<std::int8_t>(part.data);
    case 2:
      return numbers_as<std::uint8_t>(part.data);
    case 3:
      return numbers_as<std::int16_t>(part.data);
    case 4:
    case 17:  // UTF-16
      return numbers_as<std::uint16_t>(part.data);
    case 5:
      return numbers_as<std::int32_t>(part.data);
    case 6:
      return numbers_as<std::uint32_t>(part.data);
    case 7:
      return numbers_as<float>(part.data);
    case 9:
      return numbers_as<double>(part.data);
    case 12:
      return numbers_as<std::int64_t>(part.data);
    case 13:
      return numbers_as<std::uint64_t>(part.data);
    default:
      throw Broken{"has numbers of an unknown type " + std::to_string(part.type)};
  }
}

void append_utf8(std::string& text, std::uint32_t code) {
  const auto byte = [&](std::uint32_t value) { text += static_cast<char>(value); };
  if (code < 0x80) {
    byte(code);
  } else if (code < 0x800) {
    byte(0xC0 | code >> 6), byte(0x80 | (code & 0x3F));
  } else {
    byte(0xE0 | (code >> 12 & 0xF)), byte(0x80 | (code >> 6 & 0x3F)), byte(0x80 | (code & 0x3F));
  }
}

/// The letters of a text one by one, each as UTF-8.
std::vector<std::string> letters(const Parts::Part& part) {
  std::vector<std::string> out;
  if (part.type == 16 || part.type <= 2) {  // UTF-8, or bytes that are
    for (const char byte : part.data) {
      if (continues_character(byte) && !out.empty()) {
        out.back() += byte;
      } else {
        out.emplace_back(1, byte);
      }
    }
    return out;
  }
  for (const double code : numbers(part)) {
    append_utf8(out.emplace_back(), static_cast<std::uint32_t>(std::clamp(code, 0.0, 65535.0)));
  }
  return out;
}

std::vector<std::string> texts(const Parts::Part& part, Index rows, Index cols) {
  // Of no letters there is one text, however many rows they are said to stand in.
  if (rows * cols == 0) return {""};
  const std::vector<std::string> all = letters(part);
  if (std::ssize(all) != rows * cols) throw Broken{"has a text of another length than it says"};
  std::vector<std::string> out;
  for (Index i = 0; i < rows; ++i) {
    std::string& line = out.emplace_back();
    for (Index j = 0; j < cols; ++j) line += all[static_cast<std::size_t>(j * rows + i)];
    // Rows of letters are filled up to one length.
    if (rows > 1) line.erase(line.find_last_not_of(' ') + 1);
  }
  return out;
}

struct Variable {
  std::string name;
  MatValue value;
};

Variable read_variable(std::string_view data, int depth);

MatValue read_cells(Parts& parts, Index n, int depth) {
  std::vector<std::string> out;
  for (Index i = 0; i < n; ++i) {
    const Parts::Part part = parts.next();
    if (part.type != type_matrix) throw Broken{"has a cell that is no variable"};
    const MatValue value = read_variable(part.data, depth + 1).value;
    const auto* text = std::get_if<std::vector<std::string>>(&value.is);
    if (text == nullptr || text->size() != 1) return {MatOther{"a cell array of more than texts"}};
    out.push_back(text->front());
  }
  return {out};
}

MatValue read_structure(Parts& parts, Index n, int depth) {
  const std::vector<double> length = numbers(parts.next());
  if (length.size() != 1 || !(length[0] >= 1)) throw Broken{"has a structure without field names"};
  const auto size = static_cast<std::size_t>(length[0]);
  const std::string_view names = parts.next().data;
  if (n != 1) return {MatOther{"an array of structures"}};
  MatValues out;
  for (std::size_t at = 0; at + size <= names.size(); at += size) {
    const std::string_view name = names.substr(at, size);
    const Parts::Part part = parts.next();
    if (part.type != type_matrix) throw Broken{"has a field that is no variable"};
    out[std::string(name.substr(0, name.find('\0')))] = read_variable(part.data, depth + 1).value;
  }
  return {out};
}

Variable read_variable(std::string_view data, int depth) {
  if (data.empty()) return {"", {Eigen::MatrixXd(0, 0)}};
  if (depth > most_depth) throw Broken{"has variables within variables, more than 8 deep"};
  Parts parts(data);
  const std::vector<double> flags = numbers(parts.next());
  if (flags.size() != 2) throw Broken{"has a variable without flags"};
  const auto bits = static_cast<std::uint32_t>(flags[0]);
  const auto kind = static_cast<Class>(bits & 0xFF);
  const bool is_complex = (bits & 0x800) != 0;
  if (kind > Class::last_number) return {"", {MatOther{"an object"}}};  // laid out in another way
  const std::vector<double> size = numbers(parts.next());
  const std::string name(parts.next().data);
  if (size.size() < 2) throw Broken{"has a variable without a size"};
  double n_entries = 1;
  for (const double each : size) {
    if (each < 0) throw Broken{"has a variable of a negative size"};
    n_entries *= each;
  }
  if (n_entries > static_cast<double>(most_bytes)) throw Broken{"has a variable that is too large"};
  if (size.size() > 2) return {name, {MatOther{"an array of more than two dimensions"}}};
  const auto rows = static_cast<Index>(size[0]), cols = static_cast<Index>(size[1]);
  const auto value = [&]() -> MatValue {
    if (kind == Class::cell) return read_cells(parts, rows * cols, depth);
    if (kind == Class::structure) return read_structure(parts, rows * cols, depth);
    if (kind == Class::text) {
      // Of no letters nothing need stand there.
      return {texts(parts.empty() ? Parts::Part{16, {}} : parts.next(), rows, cols)};
    }
    if (kind == Class::sparse)
      return {
          MatOther{"a sparse matrix (full() makes it one that is "
                   "read)"}};
    if (kind < Class::first_number) return {MatOther{"an object"}};
    if (is_complex) return {MatOther{"a matrix of complex numbers"}};
    if (rows * cols == 0) return {Eigen::MatrixXd(rows, cols)};
    const std::vector<double> values = numbers(parts.next());
    if (std::ssize(values) != rows * cols)
      throw Broken{"has a matrix of another size than it says"};
    return {Eigen::MatrixXd(Eigen::Map<const Eigen::MatrixXd>(values.data(), rows, cols))};
  };
  return {name, value()};
}

std::string inflated(std::string_view data, std::size_t most) {
  z_stream stream{};
  if (inflateInit(&stream) != Z_OK) throw Broken{"cannot be decompressed here"};
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(data.data()));
  stream.avail_in = static_cast<uInt>(data.size());
  std::string out;
  int said = Z_OK;
  while (said == Z_OK && out.size() <= most) {
    const std::size_t before = out.size(), room = std::size_t{1} << 16;
    out.resize(before + room);
    stream.next_out = reinterpret_cast<Bytef*>(out.data() + before);
    stream.avail_out = static_cast<uInt>(room);
    said = inflate(&stream, Z_NO_FLUSH);
    out.resize(before + room - stream.avail_out);
  }
  inflateEnd(&stream);
  if (out.size() > most) throw Broken{"is larger than 64 MiB when it is decompressed"};
  if (said != Z_STREAM_END) throw Broken{"has a compressed part that is damaged"};
  return out;
}

void check_header(std::string_view bytes) {
  if (bytes.starts_with("# ") || bytes.starts_with("Octave-1")) {
    throw Broken{"is in Octave's own format, allowed is MATLAB's level 5: save -v7 FILE ..."};
  }
  if (bytes.substr(0, 8) == "\x89HDF\r\n\x1a\n" || bytes.starts_with("MATLAB 7.3")) {
    throw Broken{"is of version 7.3, allowed is level 5: save -v7 FILE ..."};
  }
  if (bytes.size() < header_size || !bytes.starts_with("MATLAB 5.0 MAT-file")) {
    throw Broken{"is no MATLAB level-5 file (save -v7 FILE ... writes one)"};
  }
  static_assert(std::endian::native == std::endian::little);
  if (bytes.substr(126, 2) != "IM") throw Broken{"has its bytes in the other order"};
}

MatValues read_all(std::string_view bytes) {
  check_header(bytes);
  MatValues out;
  std::size_t left = most_bytes;
  Parts parts(bytes.substr(header_size));
  while (!parts.empty()) {
    Parts::Part part = parts.next();
    std::string memory;
    if (part.type == type_compressed) {
      memory = inflated(part.data, left);
      left -= memory.size();
      part = Parts(memory).next();
    }
    if (part.type != type_matrix) continue;  // of a kind that no variable needs
    Variable variable = read_variable(part.data, 0);
    if (!variable.name.empty()) out[variable.name] = std::move(variable.value);
  }
  return out;
}

}  // namespace

MatValues read_mat(std::string_view bytes, const std::string& source_name) {
  try {
    return read_all(bytes);
  } catch (const Broken& broken) {
    throw InputError(source_name + ": " + broken.what);
  }
}

}  // namespace stillframe::report
