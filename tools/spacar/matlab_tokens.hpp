#pragma once

#include <string>
#include <vector>

namespace stillframe::tools::spacar {

enum class TokenKind { number, name, text, symbol, end_of_statement, end };

struct Token {
  TokenKind kind = TokenKind::end;
  std::string text;
  double number = 0;
  int line = 0;
  bool space_before = false, space_after = false;
};

/// One statement of a script: its tokens without what ends it, and its first line as it stands.
struct Statement {
  int line = 0;
  std::vector<Token> tokens;  ///< the last one is `end`
  std::string shown;
};

/// The statements of a MATLAB script: comments, continuations (...) and blocks of comments are
/// gone; rows of a matrix are parted by ';', as lines within brackets are. Errors: InputError of a
/// bracket or a text that nothing closes.
std::vector<Statement> statements_of(const std::vector<std::string>& lines,
                                     const std::string& name);

}  // namespace stillframe::tools::spacar
