#include "tools/spacar/matlab_script.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <set>

#include "tools/spacar/matlab_expression.hpp"
#include "tools/spacar/source_text.hpp"

namespace stillframe::tools::spacar {

namespace {

/// Commands that change no model.
constexpr std::array commands{"clc",  "close",   "addpath", "format", "tic",
                              "toc",  "disp",    "fprintf", "figure", "hold",
                              "grid", "warning", "which",   "more",   "pkg"};
constexpr std::array clearing{"clear", "clearvars"};
/// What may stand before an assignment in a block, without a comma between.
constexpr std::array within_blocks{"else", "elseif", "case", "otherwise", "catch"};
constexpr std::array blocks{"if", "for", "while", "switch", "try", "parfor"};

template <class Words>
bool has(const Words& words, const std::string& word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

bool is_call(const Token& token) {
  const std::string name = lower(token.text);
  return token.kind == TokenKind::name && (name == "spacarlight" || name == "spacar_light");
}

/// Where the '=' of an assignment stands.
std::optional<std::size_t> assignment(const Statement& statement) {
  int depth = 0;
  for (std::size_t i = 0; i < statement.tokens.size(); ++i) {
    const Token& token = statement.tokens[i];
    if (token.kind != TokenKind::symbol) continue;
    if (token.text == "(" || token.text == "[" || token.text == "{") ++depth;
    if (token.text == ")" || token.text == "]" || token.text == "}") --depth;
    if (token.text == "=" && depth == 0) return i;
  }
  return std::nullopt;
}

class Runner {
 public:
  Runner(const std::vector<Statement>& statements, const std::string& name)
      : statements_(statements) {
    script_.name = name;
  }

  /// What the script has from elsewhere. Errors: InputError of what is no assignment of a value, or
  /// what the script does not ask for or says itself.
  void give(const std::string& text) {
    const auto refuse_given = [&](const std::string& why) {
      throw InputError("--set " + text + ": " + why);
    };
    const std::vector<Statement> one = statements_of({text}, "--set " + text);
    const auto equals = one.size() == 1 ? assignment(one.front()) : std::nullopt;
    const std::string variable = equals ? one.front().tokens.front().text : "";
    if (!equals || one.front().tokens.front().kind != TokenKind::name || has(blocks, variable)) {
      refuse_given("found no assignment, allowed is one, NAME=VALUE");
    }
    const auto is_it = [&](const Token& token) {
      return token.kind == TokenKind::name && token.text == variable;
    };
    // nprops(2).mass, and whether one is the other or a part of it.
    const auto left_side = [](const Statement& statement, std::size_t end) {
      std::string joined;
      for (std::size_t i = 0; i < end; ++i) joined += statement.tokens[i].text;
      return joined;
    };
    const auto is_part = [](const std::string& part, const std::string& of) {
      return part.starts_with(of) &&
             (part.size() == of.size() || part[of.size()] == '.' || part[of.size()] == '(');
    };
    const std::string left = left_side(one.front(), *equals);
    bool asked = false;
    for (const Statement& statement : statements_) {
      const auto& tokens = statement.tokens;
      for (std::size_t i = 0; i < tokens.size(); ++i) {
        asked = asked || (is_it(tokens[i]) && (i == 0 || tokens[i - 1].text != "."));
      }
      const auto at = assignment(statement);
      const std::string own = at ? left_side(statement, *at) : "";
      if (at && (is_part(own, left) || is_part(left, own))) {
        refuse_given("the script says '" + shown(own) + "' itself, in line " +
                     std::to_string(statement.line));
      }
    }
    if (!asked) refuse_given("nothing in " + script_.name + " is called '" + variable + "'");
    assign(one.front(), *equals);
    const std::vector<Remark>& remarks = script_.remarks.left_out;
    if (!remarks.empty()) refuse_given(remarks.back().why);
    for (const Statement& statement : statements_) {
      if (has(clearing, statement.tokens.front().text) &&
          cleared(statement).value_or(known()).contains(variable)) {
        refuse_given("the script clears it, in line " + std::to_string(statement.line));
      }
    }
    script_.given.push_back(text);
  }

  Script run() {
    for (std::size_t i = 0; i < statements_.size(); ++i) {
      const Statement& statement = statements_[i];
      if (find_call(statement)) {
        if (i + 1 < statements_.size()) {
          script_.remarks.no_part.push_back({.line = statements_[i + 1].line,
                                             .what = "what follows the call",
                                             .why = "looks at results"});
        }
        return std::move(script_);
      }
      ++script_.n_statements;
      const std::string& first = statement.tokens.front().text;
      if (first == "function" || first == "end") continue;
      if (has(blocks, first)) {
        i = skip_block(i);
      } else if (const auto equals = assignment(statement)) {
        assign(statement, *equals);
      } else if (has(clearing, first)) {
        clear(statement);
      } else if (!has(commands, first)) {
        leave_out(statement, "is no assignment");
      }
    }
    refuse(script_.name, statements_.empty() ? 1 : statements_.back().line, "script",
           "no call of spacarlight",
           "is a script that calls spacarlight(nodes, elements, nprops, "
           "eprops, opt)");
  }

 private:
  const std::vector<Statement>& statements_;
  Script script_;

  void leave_out(const Statement& statement, const std::string& why) {
    script_.remarks.left_out.push_back(
        {.line = statement.line, .what = statement.shown, .why = why});
  }

  bool find_call(const Statement& statement) {
    const std::vector<Token>& tokens = statement.tokens;
    const auto call = std::find_if(tokens.begin(), tokens.end(), is_call);
    if (call == tokens.end() || (call + 1)->text != "(" || tokens.front().text == "function") {
      return false;
    }
    script_.call_line = statement.line;
    for (auto token = call + 2; token != tokens.end() && token->text != ")"; ++token) {
      if (token->text == ",") continue;
      const bool alone =
          token->kind == TokenKind::name && ((token + 1)->text == "," || (token + 1)->text == ")");
      if (!alone) {
        refuse(script_.name, statement.line, call->text, "'" + shown(token->text) + "'",
               "are names of variables, a comma between them");
      }
      script_.arguments.push_back(token->text);
    }
    if (script_.arguments.size() < 4 || script_.arguments.size() > 6) {
      refuse(script_.name, statement.line, call->text,
             std::to_string(script_.arguments.size()) + " arguments",
             "are nodes, elements, nprops, eprops, and opt, or rls and opt");
    }
    return true;
  }

  /// A field, and those of it: opt.rls = [] ends opt.rls(2).def.
  void forget(const Path& path) {
    std::erase_if(script_.fields, [&](const Assigned& a) {
      if (a.path.size() < path.size()) return false;
      const std::size_t last = path.size() - 1;
      return std::equal(path.begin(), path.end() - 1, a.path.begin()) &&
             a.path[last].first == path[last].first &&
             (path[last].second == 0 || a.path[last].second == path[last].second);
    });
  }

  std::set<std::string> known() const {
    std::set<std::string> names;
    for (const auto& [name, value] : script_.variables) names.insert(name);
    for (const Assigned& field : script_.fields) names.insert(field.path.front().first);
    for (const auto& [name, why] : script_.unknown) names.insert(name);
    return names;
  }

  /// The variables that a clear or clearvars ends: clear A B, clear('A', 'B'), clearvars -except A,
  /// or all of them. Nothing if it says something else, such as a pattern.
  std::optional<std::set<std::string>> cleared(const Statement& statement) const {
    std::vector<Token> rest(statement.tokens.begin() + 1, statement.tokens.end() - 1);
    const bool except = rest.size() > 2 && statement.tokens.front().text == "clearvars" &&
                        rest[0].text == "-" && rest[1].text == "except";
    if (except) rest.erase(rest.begin(), rest.begin() + 2);
    const bool call = rest.size() > 2 && rest.front().text == "(" && rest.back().text == ")";
    if (call) {
      rest.erase(rest.begin());
      rest.pop_back();
      std::erase_if(rest, [](const Token& token) {
        return token.kind == TokenKind::symbol && token.text == ",";
      });
    }
    std::set<std::string> names;
    for (const Token& token : rest) {
      const bool is_name = token.kind == (call ? TokenKind::text : TokenKind::name);
      if (!is_name || token.text.find_first_of("*?[-") != std::string::npos) return std::nullopt;
      names.insert(token.text);
    }
    std::set<std::string> all = known();
    if (except) {
      for (const std::string& name : names) all.erase(name);
      return all;
    }
    if (names.empty()) return all;
    if (names.size() == 1 && statement.tokens.front().text == "clear") {
      const std::string& word = *names.begin();
      if (word == "all" || word == "variables" || word == "classes") return all;
      if (word == "functions" || word == "mex" || word == "import") {
        return std::set<std::string>{};
      }
    }
    // What these say beside other names, or alone, is not sure.
    for (const char* word :
         {"all", "variables", "classes", "functions", "mex", "import", "global", "java"}) {
      if (names.contains(word)) return std::nullopt;
    }
    return names;
  }

  void clear(const Statement& statement) {
    const auto names = cleared(statement);
    if (!names) {
      leave_out(statement, "is read with names of variables alone");
      return;
    }
    for (const std::string& name : *names) {
      lose(name, statement, "");
      script_.unknown.erase(name);
    }
  }

  void lose(const std::string& variable, const Statement& statement, const std::string& why) {
    script_.variables.erase(variable);
    std::erase_if(script_.fields,
                  [&](const Assigned& a) { return a.path.front().first == variable; });
    script_.unknown[variable] = {statement.line, why};
  }

  void assign(const Statement& statement, std::size_t equals) {
    const std::string& variable = statement.tokens.front().text;
    Path path;
    try {
      Expression left(script_, statement.tokens, 0);
      path = left.path();
      if (left.at() != equals) throw Unknown("what stands before the '=' is not read");
      if (path.size() == 1 && path[0].second > 0) {
        throw Unknown("a part of a matrix is set, and wholes alone are read");
      }
      if (path.back().second > 0) {
        // The whole is not known any more, whatever it was.
        path.back().second = 0;
        forget(path);
        leave_out(statement, "a part of a field is set, and wholes alone are read");
        return;
      }
    } catch (const Unknown& why) {
      leave_out(statement, why.what());
      for (std::size_t i = 0; i < equals; ++i) {
        const Token& token = statement.tokens[i];
        const bool all = variable == "[";
        if (token.kind == TokenKind::name && (all || i == 0)) {
          lose(token.text, statement, why.what());
        }
      }
      return;
    }
    try {
      Value value = Expression(script_, statement.tokens, equals + 1).whole();
      if (path.size() == 1) {
        lose(variable, statement, "");
        script_.unknown.erase(variable);
        script_.variables[variable] = {std::move(value), statement.line};
      } else {
        forget(path);
        script_.fields.push_back({.path = path, .value = std::move(value), .line = statement.line});
      }
    } catch (const Unknown& why) {
      leave_out(statement, why.what());
      forget(path);
      if (path.size() == 1) lose(variable, statement, why.what());
    }
  }

  /// What a statement within a loop or a condition may set, or end.
  void lose_within(const Statement& statement) {
    constexpr const char* why = "it is set within a loop or a condition";
    const std::vector<Token>& tokens = statement.tokens;
    const std::string& first = tokens.front().text;
    if (first == "for" || first == "parfor") {
      // for i = ..., and for (i = ...).
      const auto name = std::find_if(tokens.begin() + 1, tokens.end(), [](const Token& token) {
        return token.kind == TokenKind::name;
      });
      if (name != tokens.end()) lose(name->text, statement, why);
    }
    const auto equals = assignment(statement);
    if (!equals) {
      if (!has(clearing, first)) return;
      for (const std::string& name : cleared(statement).value_or(known())) {
        lose(name, statement, why);
      }
      return;
    }
    // Of [a, b] = ... all names, and of "if c a = 1" all: where c ends is not worked out.
    const bool keyword = has(blocks, first) || has(within_blocks, first);
    for (std::size_t i = keyword ? 1 : 0; i < *equals; ++i) {
      if (tokens[i].kind != TokenKind::name) continue;
      lose(tokens[i].text, statement, why);
      if (!keyword && first != "[") break;
    }
  }

  /// From a loop or a condition to its end. What is set within is unknown.
  std::size_t skip_block(std::size_t i) {
    const Statement& head = statements_[i];
    leave_out(head, "loops and conditions are not run");
    int depth = 0;
    for (; i < statements_.size(); ++i) {
      const Statement& statement = statements_[i];
      const std::string& first = statement.tokens.front().text;
      if (has(blocks, first)) ++depth;
      if (first == "end" && --depth == 0) return i;
      lose_within(statement);
    }
    refuse(script_.name, head.line, head.tokens.front().text, "no end of it",
           "is a block that 'end' closes");
  }
};

}  // namespace

Script run_script(const std::vector<std::string>& lines, const std::string& name,
                  const std::vector<std::string>& given) {
  const std::vector<Statement> statements = statements_of(lines, name);
  Runner runner(statements, name);
  for (const std::string& text : given) runner.give(text);
  return runner.run();
}

}  // namespace stillframe::tools::spacar
