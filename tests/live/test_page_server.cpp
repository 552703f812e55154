#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <memory>
#include <vector>

#include "core/errors/input_error.hpp"
#include "msgs/clock.hpp"
#include "report/live/page_connection.hpp"
#include "report/live/page_server.hpp"
#include "tests/live/http_client.hpp"
#include "tests/support/quarantine.hpp"

namespace stillframe::live {
namespace {

const std::string ask_events = "GET /events HTTP/1.1\r\nHost: localhost\r\n\r\n";

/// Returns once it is so; a test that waits in vain is ended from outside.
template <class Condition>
void wait_until(Condition condition) {
  while (!condition()) usleep(1000);
}

std::int64_t resident_bytes() {
  std::ifstream file("/proc/self/statm");
  std::int64_t size = 0, resident = 0;
  file >> size >> resident;
  return resident * sysconf(_SC_PAGESIZE);
}

std::string status_of(const std::string& answer) { return answer.substr(0, answer.find("\r\n")); }

TEST(PageServer, GivesThePageAndItsPartsAndNothingElse) {
  PageServer server(0);
  const std::string page = get(server.port(), "/");
  EXPECT_EQ(status_of(page), "HTTP/1.1 200 OK");
  EXPECT_NE(page.find("<title>stillframe live</title>"), std::string::npos);
  EXPECT_NE(page.find("Content-Security-Policy: default-src 'none'"), std::string::npos);
  EXPECT_EQ(page.find("http://"), std::string::npos);  // nothing from elsewhere
  EXPECT_EQ(page.find("https://"), std::string::npos);
  EXPECT_NE(get(server.port(), "/live.js").find("EventSource"), std::string::npos);
  EXPECT_NE(get(server.port(), "/live.css").find("--surface"), std::string::npos);
  for (const char* path : {"/etc/passwd", "/../etc/passwd", "/live.js.map", "/events/", "//"}) {
    EXPECT_EQ(status_of(get(server.port(), path)), "HTTP/1.1 404 Not Found") << path;
  }
}

/// A page from elsewhere may have a name that leads to 127.0.0.1, but not one of these.
TEST(PageServer, AnswersOnlyToTheNamesOfThisMachine) {
  PageServer server(0);
  server.publish("{}");
  const std::string port = ":" + std::to_string(server.port());
  for (const char* host : {"localhost", "127.0.0.1", "[::1]"}) {
    for (const std::string& name : {std::string(host), host + port}) {
      EXPECT_TRUE(is_own_host(name, server.port())) << name;
      EXPECT_EQ(status_of(get(server.port(), "/view", "Host: " + name + "\r\n")),
                "HTTP/1.1 200 OK");
    }
  }
  for (const std::string& name :
       {std::string("evil.example"), "localhost.evil.example" + port, std::string("localhost:1"),
        "127.0.0.1.evil.example" + port, std::string("127.0.0.2"), std::string("")}) {
    EXPECT_FALSE(is_own_host(name, server.port())) << name;
    for (const char* path : {"/", "/view", "/events", "/live.js"}) {
      EXPECT_EQ(status_of(get(server.port(), path, "Host: " + name + "\r\n")),
                "HTTP/1.1 403 Forbidden")
          << name << path;
    }
  }
  EXPECT_EQ(status_of(get(server.port(), "/view", "X: no host at all\r\n")),
            "HTTP/1.1 403 Forbidden");
}

TEST(PageServer, IsNotThereForOtherMachines) {
  PageServer server(0);
  std::ifstream table("/proc/net/tcp");
  char hexadecimal[5];
  std::snprintf(hexadecimal, sizeof hexadecimal, "%04X", server.port());
  int n_listening = 0;
  for (std::string line; std::getline(table, line);) {
    if (line.find(std::string(":") + hexadecimal + " 00000000:0000 0A") == std::string::npos)
      continue;
    ++n_listening;
    EXPECT_NE(line.find("0100007F:"), std::string::npos) << line;  // 127.0.0.1
  }
  EXPECT_EQ(n_listening, 1);
}

TEST(PageServer, APortThatIsTakenIsAnError) {
  PageServer first(0);
  EXPECT_THROW(PageServer second(first.port()), InputError);
  EXPECT_EQ(status_of(get(first.port(), "/")), "HTTP/1.1 200 OK");
}

TEST(PageServer, ThereIsNoViewBeforeTheFirst) {
  PageServer server(0);
  EXPECT_EQ(status_of(get(server.port(), "/view")), "HTTP/1.1 503 Service Unavailable");
  server.publish("{\"n\":1}");
  server.publish("{\"n\":2}");
  const std::string answer = get(server.port(), "/view");
  EXPECT_NE(answer.find("\r\n\r\n{\"n\":2}\n"), std::string::npos) << answer;
}

TEST(PageServer, EveryBrowserGetsTheNewestAndEachOneAfter) {
  PageServer server(0);
  server.publish("{\"n\":1}");
  Connection one(server.port()), two(server.port());
  one.send(ask_events);
  EXPECT_NE(one.read_until("data: {\"n\":1}\n\n").find("text/event-stream"), std::string::npos);
  server.publish("{\"n\":2}");
  one.read_until("data: {\"n\":2}\n\n");
  two.send(ask_events);  // attaches in the middle
  EXPECT_EQ(two.read_until("data: {\"n\":2}\n\n").find("\"n\":1"), std::string::npos);
  for (int n = 3; n < 50; ++n) {
    const std::string event = "data: {\"n\":" + std::to_string(n) + "}\n\n";
    server.publish("{\"n\":" + std::to_string(n) + "}");
    EXPECT_NE(one.read_until(event).find(event), std::string::npos);
    EXPECT_NE(two.read_until(event).find(event), std::string::npos);
  }
  EXPECT_EQ(server.n_streams(), 2);
  // Each of them once.
  const std::string all = one.read_until("");
  for (int n = 1; n < 50; ++n) {
    const std::string event = "data: {\"n\":" + std::to_string(n) + "}\n\n";
    EXPECT_EQ(all.find(event), all.rfind(event)) << n;
  }
}

TEST(PageServer, BrowsersComeAndGo) {
  PageServer server(0);
  for (int round = 0; round < 5; ++round) {
    {
      std::vector<std::unique_ptr<Connection>> browsers;
      for (int i = 0; i < 20; ++i) {
        browsers.push_back(std::make_unique<Connection>(server.port()));
        browsers.back()->send(ask_events);
      }
      wait_until([&] { return server.n_streams() == 20; });
    }
    wait_until([&] {
      server.publish("{}");
      return server.n_streams() == 0;
    });
  }
}

/// Browsers that ask and never read: views of a quarter of a megabyte, a thousand of them. If they
/// were kept for the slow ones it would be four gigabytes, and the fast one would not get its own.
TEST(PageServer, BrowsersThatHangHoldNobodyUpAndCostNoMemory) {
  PageServer server(0);
  std::vector<std::unique_ptr<Connection>> hanging;
  for (int i = 0; i < 16; ++i) {
    hanging.push_back(std::make_unique<Connection>(server.port()));
    hanging.back()->send(ask_events);
  }
  wait_until([&] { return server.n_streams() == 16; });
  const std::string big(250'000, 'x');
  server.publish(big + "first");
  const std::int64_t before = resident_bytes();
  std::int64_t longest_ns = 0;
  for (int n = 0; n < 1000; ++n) {
    const std::int64_t began = monotonic_ns();
    server.publish(big + std::to_string(n));
    longest_ns = std::max(longest_ns, monotonic_ns() - began);
  }
  // A view each that is on its way, and what malloc keeps; the kernel's buffers are not ours.
  EXPECT_LT(resident_bytes() - before, (std::int64_t{64} << 20) + test::quarantine_bytes);
  Connection quick(server.port());
  quick.send(ask_events);
  EXPECT_NE(quick.read_until("999\n\n").find("999\n\n"), std::string::npos);
  // Waiting for one of them would be the 2 s after which its connection is given up.
  EXPECT_LT(longest_ns, 1'000'000'000);
  // They are given up: views of that size, as small ones would take minutes to fill the buffers of
  // one that had missed most of the thousand.
  wait_until([&] {
    server.publish(big);
    return server.n_streams() <= 1;
  });
}

TEST(PageServer, OneTooManyIsToldToComeAgain) {
  PageServer server(0);
  std::vector<std::unique_ptr<Connection>> browsers;
  for (int i = 0; i < PageServer::most_streams; ++i) {
    browsers.push_back(std::make_unique<Connection>(server.port()));
    browsers.back()->send(ask_events);
  }
  wait_until([&] { return server.n_streams() == PageServer::most_streams; });
  EXPECT_EQ(status_of(get(server.port(), "/events")), "HTTP/1.1 503 Service Unavailable");
  EXPECT_EQ(status_of(get(server.port(), "/")), "HTTP/1.1 200 OK");  // the page is still there
  browsers.pop_back();
  wait_until([&] {
    server.publish("{}");
    return server.n_streams() < PageServer::most_streams;
  });
  Connection next(server.port());
  next.send(ask_events);
  EXPECT_NE(next.read_until("data: {}").find("data: {}"), std::string::npos);
}

/// The end of a stream is a whole answer, so that a browser has nothing to complain of.
TEST(PageServer, StopsWholeWithBrowsersAttached) {
  auto server = std::make_unique<PageServer>(0);
  server->publish("{}");
  Connection listening(server->port()), hanging(server->port()), silent(server->port());
  listening.send(ask_events);
  listening.read_until("data: {}");
  hanging.send(ask_events);
  wait_until([&] { return server->n_streams() == 2; });
  server.reset();
  const std::string all = listening.read_all();
  EXPECT_EQ(all.substr(all.size() - 5), "0\r\n\r\n");
}

/// What is no request of ours gets an answer or none, and the server lives on.
TEST(PageServer, NonsenseDoesNoHarm) {
  PageServer server(0);
  server.publish("{}");
  for (const std::string& text :
       {std::string("\r\n\r\n"), std::string("GET\r\n\r\n"), std::string(100'000, 'A'),
        std::string("POST /view HTTP/1.1\r\nHost: localhost\r\nContent-Length: 99999999\r\n\r\nx"),
        std::string("GET /view HTTP/1.1\r\nHost: localhost\r\nRange: bytes=0-0,5-1,-\r\n\r\n"),
        std::string(300, '\0')}) {
    Connection connection(server.port());
    connection.send(text);
  }
  EXPECT_EQ(status_of(get(server.port(), "/view")), "HTTP/1.1 200 OK");
}

/// A request that does not end: headers, one header, a body of chunks that nobody asked for.
TEST(PageServer, ARequestWithoutEndIsGivenUpAndCostsNoMemory) {
  PageServer server(0);
  server.publish("{}");
  const std::string begin = "GET /view HTTP/1.1\r\nHost: localhost\r\n";
  for (const std::string& text : {std::string("X: y\r\n"), std::string("xxxxxxxx"),
                                  std::string("Transfer-Encoding: chunked\r\n\r\nfffffff\r\nx")}) {
    std::string piece;
    while (piece.size() < 1'000'000) piece += text;
    const std::int64_t before = resident_bytes();
    Connection connection(server.port());
    connection.send(begin);
    for (int i = 0; i < 64; ++i) connection.send(piece);  // 64 MB, if anybody took them
    connection.read_all();                                // the other side has closed
    // A tenth of what was sent; what malloc keeps of the few kilobytes that were read is less.
    EXPECT_LT(resident_bytes() - before, (std::int64_t{6} << 20) + test::quarantine_bytes);
  }
  EXPECT_EQ(status_of(get(server.port(), "/view")), "HTTP/1.1 200 OK");
}

/// The limit is one for all of a request: bytes that come one by one do not move it. Once it is
/// over nobody waits for another one; a read that did would take the whole limit, however quick the
/// machine, and one that does not can be that late only now and then, however slow.
TEST(PageConnection, BytesThatDripDoNotMoveTheLimitOfTheRequest) {
  using std::chrono::steady_clock;
  int ends[2];
  ASSERT_EQ(socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
  constexpr std::chrono::milliseconds limit(200);
  PageConnection connection(ends[0], {.bytes = 1u << 30, .read = limit, .write = limit});
  const auto over = steady_clock::now() + limit;
  char byte = 0;
  while (steady_clock::now() < over) {
    ASSERT_EQ(::send(ends[1], "x", 1, MSG_NOSIGNAL), 1);
    ASSERT_EQ(connection.read(&byte, 1), 1);
  }
  auto shortest = steady_clock::duration::max();
  for (int i = 0; i < 10; ++i) {
    const auto began = steady_clock::now();
    ASSERT_EQ(connection.read(&byte, 1), -1);
    shortest = std::min(shortest, steady_clock::now() - began);
  }
  EXPECT_LT(shortest, limit / 2);
  close(ends[1]);
}

/// One that is asked byte by byte, each in time, and never ends: closed after two seconds in all.
TEST(PageServer, ASlowRequestIsGivenUp) {
  PageServer server(0);
  Connection connection(server.port());
  connection.send("GET /view HTTP/1.1\r\nHost: ");
  // That it is, and not for its 8192 bytes; how soon, the connection's own test asks.
  int n_sent = 0;
  while (!connection.hears_within(100) && n_sent < 600) {
    connection.send("x");
    ++n_sent;
  }
  EXPECT_LT(n_sent, 600);
}

TEST(PageServer, OnlyAsksAreAnswered) {
  PageServer server(0);
  server.publish("{}");
  for (const char* method : {"POST", "PUT", "DELETE", "PATCH", "OPTIONS"}) {
    Connection connection(server.port());
    connection.send(std::string(method) +
                    " /view HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\n\r\n");
    EXPECT_EQ(status_of(connection.read_all()), "HTTP/1.1 405 Method Not Allowed") << method;
  }
}

}  // namespace
}  // namespace stillframe::live
