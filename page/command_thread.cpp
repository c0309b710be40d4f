#include "page/command_thread.h"

#include <unistd.h>

#include <utility>  // before boost/asio/awaitable.hpp, which takes it for granted

#include <boost/asio/awaitable.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/this_coro.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <cstdio>
#include <optional>
#include <stdexcept>
#include <thread>

#include "page/view_json.h"
#include "print/operator/operator_client.h"
#include "runtime/precedence.h"

namespace firn::page {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using asio::ip::tcp;
using namespace std::chrono_literals;
using Request = http::request<http::string_body>;

constexpr std::chrono::seconds kPatience{10};  // for an answer to an order
constexpr auto kTryAgain = 25ms;               // to connect to a print that accepts others
constexpr int kMaxLines = 32;

// The order goes the way of firn ctl, to the launcher; the frame answers the browser.
asio::awaitable<std::string> pass_on(OrderedRun run, ClientFrame frame) {
  std::string error, words;
  try {
    const auto executor = co_await asio::this_coro::executor;
    asio::steady_timer patience(executor, kPatience);
    std::unique_ptr<OperatorClient> connected;
    for (auto until = patience.expiry();
         !(connected = OperatorClient::try_connect(run.folder, run.run_id));) {
      if (std::chrono::steady_clock::now() >= until)
        throw std::runtime_error("the print has accepted nobody for 10 s");
      asio::steady_timer pause(executor, kTryAgain);
      co_await pause.async_wait(asio::use_awaitable);
    }
    OperatorClient& client = *connected;
    client.say("from " + (run.person.empty() ? "page" : run.person + " (page)"));
    client.send(parse_order(frame.words));
    asio::posix::stream_descriptor readable(executor, ::dup(client.fd()));
    patience.async_wait([&readable](boost::system::error_code stopped) {
      boost::system::error_code ignored;
      if (!stopped) readable.cancel(ignored);
    });
    std::optional<std::string> line;
    for (boost::system::error_code ended; !line && !ended && !client.closed();) {
      line = client.next(0.0);
      if (!line)
        co_await readable.async_wait(asio::posix::stream_descriptor::wait_read,
                                     asio::redirect_error(asio::use_awaitable, ended));
    }
    patience.cancel();
    if (!line)
      error =
          client.closed() ? "the print ended before it answered" : "the print has not answered within 10 s";
    else if (line->starts_with("ok "))
      words = line->substr(3);
    else
      error = line->substr(line->find(' ') + 1);
  } catch (const std::exception& e) {
    error = e.what();
  }
  co_return answer_frame(frame.id, error.empty(), error, words);
}

asio::awaitable<void> serve(tcp::socket socket, Request request, OrderedRun run) {
  beast::websocket::stream<beast::tcp_stream> ws(std::move(socket));
  ws.set_option(beast::websocket::stream_base::timeout{kPatience, 60s, true});
  ws.read_message_max(kMaxFrameBytes);
  ws.auto_fragment(false);
  ws.set_option(beast::websocket::stream_base::decorator([](beast::websocket::response_type& response) {
    response.set(http::field::sec_websocket_protocol, CommandThread::kProtocol);
  }));
  co_await ws.async_accept(request, asio::use_awaitable);
  beast::flat_buffer buffer;
  for (;;) {
    co_await ws.async_read(buffer, asio::use_awaitable);
    std::string answer;
    std::optional<ClientFrame> command;
    try {
      const auto data = buffer.data();
      ClientFrame frame = parse_client_frame({static_cast<const char*>(data.data()), data.size()});
      if (frame.kind != ClientFrame::Kind::kCommand) throw std::invalid_argument("only commands here");
      command = std::move(frame);
    } catch (const std::exception& e) {
      answer = error_frame(e.what());
    }
    buffer.consume(buffer.size());
    if (command) {
      auto obeyed = pass_on(run, std::move(*command));
      answer = co_await std::move(obeyed);
    }
    ws.text(true);
    co_await ws.async_write(asio::buffer(answer), asio::use_awaitable);
  }
}

}  // namespace

void run_through(const std::function<void()>& run) {
  for (;;) try {
      run();
      return;
    } catch (const std::exception& e) {
      std::fprintf(stderr, "page: %s\n", e.what());
    }
}

class CommandThread::Impl {
 public:
  Impl()
      : work_(asio::make_work_guard(io)), thread_([this] {
          const Precedence precedence;
          run_through([this] { io.run(); });
        }) {}
  ~Impl() {
    io.stop();
    thread_.join();
  }

  asio::io_context io{1};
  int lines = 0;

 private:
  asio::executor_work_guard<asio::io_context::executor_type> work_;
  std::thread thread_;
};

CommandThread::CommandThread() : impl_(std::make_unique<Impl>()) {}
CommandThread::~CommandThread() = default;

void CommandThread::take(int fd, bool v6, std::string request, OrderedRun run) {
  asio::post(impl_->io,
             [impl = impl_.get(), fd, v6, text = std::move(request), run = std::move(run)]() mutable {
               tcp::socket mine(impl->io, v6 ? tcp::v6() : tcp::v4(), fd);
               http::request_parser<http::string_body> parser;
               boost::system::error_code error;
               parser.put(asio::buffer(text), error);
               if (error || !parser.is_done() || impl->lines >= kMaxLines) return;  // closes it
               ++impl->lines;
               asio::co_spawn(impl->io, serve(std::move(mine), parser.release(), std::move(run)),
                              [impl](const std::exception_ptr&) { --impl->lines; });
             });
}

void CommandThread::obey(OrderedRun run, ClientFrame frame, std::function<void(std::string)> done) {
  asio::co_spawn(
      impl_->io, pass_on(std::move(run), std::move(frame)),
      [done = std::move(done)](const std::exception_ptr&, std::string answer) { done(std::move(answer)); });
}

}  // namespace firn::page
