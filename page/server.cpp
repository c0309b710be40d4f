#include "page/server.h"

#include <unistd.h>

#include <utility>  // before boost/asio/awaitable.hpp, which takes it for granted

#include <algorithm>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <cstdio>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <stdexcept>

#include "files/text_file.h"
#include "files/usage_error.h"
#include "page/bundle.h"
#include "page/client_frame.h"
#include "page/run_set.h"
#include "page/view_json.h"
#include "page/web_rules.h"
#include "print/operator/operator_client.h"

namespace firn::page {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace fs = std::filesystem;
using asio::ip::tcp;
using namespace std::chrono_literals;

constexpr auto kTick = 50ms;
constexpr auto kMapPause = 100ms;                                // between two maps that are being measured
constexpr auto kStatePause = 250ms;                              // between two states without an event
constexpr auto kPatience = 10s;                                  // for a request, for an answer to an order
constexpr std::size_t kMostWaitingBytes = std::size_t(4) << 20;  // of text for one tab
constexpr int kSocketBuffer = 1 << 19;                           // so much of a map may wait in the kernel
constexpr int kPortsToTry = 20;

using Request = http::request<http::string_body>;
using Response = http::response<http::string_body>;
using Socket = beast::websocket::stream<beast::tcp_stream>;
template <class T>
using Shared = std::shared_ptr<const T>;

double steady_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::string to_string(beast::string_view text) { return {text.data(), text.size()}; }

// One browser's WebSocket. It reads as fast as it likes: text waits up to a limit, of maps only the newest.
class Tab : public std::enable_shared_from_this<Tab> {
 public:
  explicit Tab(tcp::socket socket) : socket_(std::move(socket)) {}

  Socket& socket() { return socket_; }
  void push(Shared<std::string> text) {
    waiting_bytes_ += text->size();
    if (waiting_bytes_ > kMostWaitingBytes) return close();
    texts_.push_back(std::move(text));
    write_next();
  }
  void push(const std::string& text) { push(std::make_shared<const std::string>(text)); }
  void push_map(Shared<std::vector<std::byte>> map) {
    map_ = std::move(map);
    write_next();
  }
  void close() {
    boost::system::error_code ignored;
    beast::get_lowest_layer(socket_).socket().close(ignored);
  }

  std::shared_ptr<WatchedRun> run;
  std::optional<Surface> follows;

 private:
  void write_next() {
    if (writing_ || (texts_.empty() && !map_)) return;
    writing_ = true;
    const auto done = [self = shared_from_this()](boost::system::error_code error, std::size_t) {
      self->writing_ = false;
      self->map_in_flight_.reset();
      if (error) return;
      self->write_next();
    };
    if (!texts_.empty()) {
      socket_.text(true);
      text_in_flight_ = std::move(texts_.front());
      texts_.pop_front();
      waiting_bytes_ -= text_in_flight_->size();
      socket_.async_write(asio::buffer(*text_in_flight_), done);
    } else {
      socket_.binary(true);
      map_in_flight_ = std::exchange(map_, nullptr);
      socket_.async_write(asio::buffer(*map_in_flight_), done);
    }
  }

  Socket socket_;
  bool writing_ = false;
  std::deque<Shared<std::string>> texts_;
  std::size_t waiting_bytes_ = 0;
  Shared<std::string> text_in_flight_;
  Shared<std::vector<std::byte>> map_, map_in_flight_;
};

class Server {
 public:
  explicit Server(const ServerOptions& options)
      : options_(options), runs_(options.places, options.live), acceptor_(io_), timer_(io_) {}

  void run() {
    listen();
    asio::co_spawn(io_, accept(), asio::detached);
    asio::co_spawn(io_, watch(), asio::detached);
    std::optional<asio::posix::stream_descriptor> stop;
    if (options_.stop_fd >= 0) {
      stop.emplace(io_, ::dup(options_.stop_fd));
      stop->async_wait(asio::posix::stream_descriptor::wait_read,
                       [this](boost::system::error_code) { io_.stop(); });
    }
    for (;;) try {
        io_.run();
        return;
      } catch (const std::exception& e) {  // of one connection or one run: the others go on
        std::fprintf(stderr, "page: %s\n", e.what());
      }
  }

 private:
  void listen();
  asio::awaitable<void> accept();
  asio::awaitable<void> serve(tcp::socket socket);
  asio::awaitable<void> serve_tab(tcp::socket socket, Request request);
  asio::awaitable<void> obey(std::shared_ptr<Tab> tab, ClientFrame frame);
  asio::awaitable<void> watch();
  Response answer(const Request& request);
  Response answer_api(const Request& request, const std::vector<std::string>& parts);
  Response take_notes(const Request& request, const std::string& id);
  void take(const std::shared_ptr<Tab>& tab, std::string_view text);
  void follow(const std::shared_ptr<Tab>& tab, const ClientFrame& frame);
  void look(const std::shared_ptr<WatchedRun>& run);
  void send_maps(WatchedRun& run, bool rows);

  const ServerOptions& options_;
  RunSet runs_;
  asio::io_context io_{1};
  tcp::acceptor acceptor_;
  asio::steady_timer timer_;
  std::vector<std::string> own_;
  std::set<std::shared_ptr<Tab>> tabs_;
  std::set<fs::path> troubled_;
  int connections_ = 0;
  std::chrono::steady_clock::time_point last_state_{}, last_rows_{};
};

void Server::listen() {
  boost::system::error_code error;
  const auto address = asio::ip::make_address(options_.bind, error);
  if (error) throw UsageError("--bind " + options_.bind + ": is no address of this machine");
  const bool any_port = options_.port == 0;
  for (int n = 0;; ++n) {
    const int port = any_port ? (n < kPortsToTry ? kFirstPort + n : 0) : options_.port;
    const tcp::endpoint at(address, std::uint16_t(port));
    acceptor_.open(at.protocol(), error);
    if (!error) acceptor_.set_option(tcp::acceptor::reuse_address(true), error);
    if (!error) acceptor_.bind(at, error);
    if (!error) acceptor_.listen(tcp::acceptor::max_listen_connections, error);
    if (!error) break;
    boost::system::error_code ignored;
    acceptor_.close(ignored);
    if (!any_port || port == 0 || error != asio::error::address_in_use)
      throw UsageError("cannot listen on " + options_.bind + ":" + std::to_string(port) + ": " +
                       error.message());
  }
  const int port = acceptor_.local_endpoint().port();
  own_ = own_authorities(options_.bind, port, options_.hosts);
  const bool any = options_.bind == "0.0.0.0" || options_.bind == "::";
  const std::string shown = any ? "127.0.0.1" : address.is_v6() ? "[" + options_.bind + "]" : options_.bind;
  if (options_.listening) options_.listening("http://" + shown + ":" + std::to_string(port) + "/");
}

asio::awaitable<void> Server::accept() {
  for (;;) {
    boost::system::error_code error;
    tcp::socket socket = co_await acceptor_.async_accept(asio::redirect_error(asio::use_awaitable, error));
    if (error == asio::error::operation_aborted) co_return;
    if (error) {  // no descriptor is free: others must be closed first
      asio::steady_timer pause(io_, kTick);
      co_await pause.async_wait(asio::use_awaitable);
      continue;
    }
    if (connections_ >= kMostConnections) continue;  // closes it
    socket.set_option(tcp::no_delay(true), error);
    socket.set_option(asio::socket_base::send_buffer_size(kSocketBuffer), error);
    ++connections_;
    asio::co_spawn(io_, serve(std::move(socket)), [this](const std::exception_ptr&) { --connections_; });
  }
}

asio::awaitable<void> Server::serve(tcp::socket socket) {
  beast::tcp_stream stream(std::move(socket));
  beast::flat_buffer buffer(1 << 16);
  for (bool go_on = true; go_on;) {
    http::request_parser<http::string_body> parser;
    parser.header_limit(8192);
    parser.body_limit(kMostNotesBytes + 1024);
    stream.expires_after(kPatience);
    co_await http::async_read(stream, buffer, parser, asio::use_awaitable);
    Request request = parser.release();
    if (beast::websocket::is_upgrade(request) && request.target().starts_with("/ws") &&
        host_allowed(to_string(request[http::field::host]), own_) &&
        origin_allowed(to_string(request[http::field::origin]), own_)) {
      stream.expires_never();
      co_return co_await serve_tab(stream.release_socket(), std::move(request));
    }
    Response response = answer(request);
    go_on = response.keep_alive();
    stream.expires_after(kPatience);
    co_await http::async_write(stream, response, asio::use_awaitable);
  }
  boost::system::error_code ignored;
  stream.socket().shutdown(tcp::socket::shutdown_send, ignored);
}

std::string run_of(std::string_view target) {
  const std::size_t at = target.find("run=");
  if (at == target.npos) return "live";
  std::string_view value = target.substr(at + 4);
  value = value.substr(0, value.find('&'));
  const auto parts = path_parts("/" + std::string(value));
  return parts.size() == 1 ? parts.front() : "";
}

asio::awaitable<void> Server::serve_tab(tcp::socket socket, Request request) {
  const auto tab = std::make_shared<Tab>(std::move(socket));
  Socket& ws = tab->socket();
  beast::websocket::stream_base::timeout timeout{kPatience, 60s, true};
  ws.set_option(timeout);
  ws.read_message_max(kMostFrameBytes);
  ws.auto_fragment(false);
  co_await ws.async_accept(request, asio::use_awaitable);
  const std::string id = run_of(to_string(request.target()));
  std::string trouble = "no run '" + id.substr(0, 100) + "'";
  try {
    tab->run = runs_.open(id, steady_s());
  } catch (const std::exception& e) {
    trouble = e.what();
  }
  if (!tab->run) {
    const std::string text = error_frame(trouble);
    co_await ws.async_write(asio::buffer(text), asio::use_awaitable);
    co_await ws.async_close(beast::websocket::close_code::policy_error, asio::use_awaitable);
    co_return;
  }
  look(tab->run);  // so that nothing of before comes after the greeting
  tab->push(tab->run->hello(steady_s()));
  tabs_.insert(tab);
  beast::flat_buffer buffer;
  boost::system::error_code error;
  while (!error) {
    co_await ws.async_read(buffer, asio::redirect_error(asio::use_awaitable, error));
    if (error) break;
    const auto data = buffer.data();
    take(tab, {static_cast<const char*>(data.data()), data.size()});
    buffer.consume(buffer.size());
  }
  tabs_.erase(tab);
}

void Server::take(const std::shared_ptr<Tab>& tab, std::string_view text) {
  ClientFrame frame;
  try {
    if (!tab->socket().got_text()) throw std::invalid_argument("a frame must be text");
    frame = parse_client_frame(text);
  } catch (const std::exception& e) {
    return tab->push(error_frame(e.what()));
  }
  if (frame.kind == ClientFrame::Kind::kPing) return tab->push(pong_frame(frame.id, steady_s()));
  if (frame.kind == ClientFrame::Kind::kFollow) return follow(tab, frame);
  if (options_.token.empty() || !same_secret(frame.token, options_.token))
    return tab->push(
        answer_frame(frame.id, false,
                     "the token is missing or wrong: it stands in the address that the terminal shows", ""));
  asio::co_spawn(io_, obey(tab, std::move(frame)), asio::detached);
}

void Server::follow(const std::shared_ptr<Tab>& tab, const ClientFrame& frame) {
  if (!frame.layer) tab->follows = frame.surface;
  if (!frame.surface) return;
  const auto layer = frame.layer ? frame.layer : tab->run->newest_layer();
  auto map = layer ? tab->run->map({*frame.surface, *layer}) : std::nullopt;
  if (map) return tab->push_map(std::make_shared<const std::vector<std::byte>>(std::move(*map)));
  if (frame.layer)
    tab->push(answer_frame(std::nullopt, false,
                           "layer " + std::to_string(*frame.layer) + " has no map '" +
                               std::string(word_of(*frame.surface)) + "'",
                           ""));
}

// The order goes the way of firn ctl, to the launcher.
asio::awaitable<void> Server::obey(std::shared_ptr<Tab> tab, ClientFrame frame) {
  std::string error, words;
  try {
    OperatorClient client(tab->run->folder());
    client.say("from page");
    client.send(parse_order(frame.words));
    asio::posix::stream_descriptor readable(io_, ::dup(client.fd()));
    asio::steady_timer patience(io_, kPatience);
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
  tab->push(answer_frame(frame.id, error.empty(), error, words));
}

asio::awaitable<void> Server::watch() {
  for (;;) {
    timer_.expires_after(kTick);
    co_await timer_.async_wait(asio::use_awaitable);
    for (const auto& run : runs_.opened()) try {
        look(run);
      } catch (const std::exception& e) {  // the run was moved away, or cannot be read any more
        if (troubled_.insert(run->folder()).second) std::fprintf(stderr, "page: %s\n", e.what());
      }
    if (std::chrono::steady_clock::now() < last_state_ + kStatePause) continue;
    last_state_ = std::chrono::steady_clock::now();
    runs_.read_one_error();
    for (const auto& tab : std::set(tabs_))
      if (tab->run->live()) tab->push(tab->run->state(steady_s()));
  }
}

void Server::look(const std::shared_ptr<WatchedRun>& run) {
  const WatchedRun::News news = run->poll(steady_s());
  for (const std::string& frame : news.frames) {
    const auto shared = std::make_shared<const std::string>(frame);
    for (const auto& tab : std::set(tabs_))  // a tab that is too slow is closed on the way
      if (tab->run == run) tab->push(shared);
  }
  if (news.map) return send_maps(*run, false);
  if (!news.rows || std::chrono::steady_clock::now() < last_rows_ + kMapPause) return;
  last_rows_ = std::chrono::steady_clock::now();
  send_maps(*run, true);
}

void Server::send_maps(WatchedRun& run, bool rows) {
  std::map<Surface, Shared<std::vector<std::byte>>> made;  // one for all tabs
  for (const auto& tab : tabs_) {
    if (tab->run.get() != &run || !tab->follows || (rows && *tab->follows != Surface::kMeasured)) continue;
    auto& map = made[*tab->follows];
    if (!map) {
      auto frame = rows ? run.partial_map() : run.map({*tab->follows, run.newest_layer().value_or(0)});
      if (!frame) continue;
      map = std::make_shared<const std::vector<std::byte>>(std::move(*frame));
    }
    tab->push_map(map);
  }
}

Response reply(const Request& request, http::status status, std::string type, std::string body) {
  Response r(status, request.version());
  r.set(http::field::content_type, type);
  r.set(http::field::cache_control, "no-store");
  r.set("X-Content-Type-Options", "nosniff");
  r.set("Referrer-Policy", "no-referrer");
  r.set("Content-Security-Policy",
        "default-src 'self'; img-src 'self' data: blob:; object-src 'none'; base-uri 'none'; form-action "
        "'none'; "
        "frame-ancestors 'none'");
  r.keep_alive(request.keep_alive());
  if (request.method() != http::verb::head) r.body() = std::move(body);
  r.prepare_payload();
  return r;
}

Response refuse(const Request& request, http::status status, const std::string& why) {
  return reply(request, status, "application/json", error_frame(why));
}

Response give(const Request& request, const Asset& asset) {
  if (to_string(request[http::field::if_none_match]) == asset.etag) {
    Response r = reply(request, http::status::not_modified, std::string(asset.type), "");
    r.set(http::field::etag, std::string(asset.etag));
    return r;
  }
  const bool packed = to_string(request[http::field::accept_encoding]).find("gzip") != std::string::npos;
  std::string body = packed ? std::string(reinterpret_cast<const char*>(asset.gzip.data()), asset.gzip.size())
                            : plain(asset);
  Response r = reply(request, http::status::ok, std::string(asset.type), std::move(body));
  r.set(http::field::etag, std::string(asset.etag));
  r.set(http::field::cache_control, "no-cache");
  if (packed) r.set(http::field::content_encoding, "gzip");
  return r;
}

Response Server::answer(const Request& request) {
  if (!host_allowed(to_string(request[http::field::host]), own_))
    return refuse(request, http::status::forbidden, "Host is not this page's");
  if (!origin_allowed(to_string(request[http::field::origin]), own_))
    return refuse(request, http::status::forbidden, "Origin is not this page's");
  try {
    const auto parts = path_parts(to_string(request.target()));
    if (parts.size() >= 2 && parts[0] == "api" && parts[1] == "runs") return answer_api(request, parts);
    if (request.method() != http::verb::get && request.method() != http::verb::head)
      return refuse(request, http::status::method_not_allowed, "only GET");
    std::string path;
    for (const std::string& part : parts) path += "/" + part;
    const Asset* asset = find_asset(path == "/" ? "/index.html" : path);
    return asset ? give(request, *asset) : refuse(request, http::status::not_found, "there is no such page");
  } catch (const std::exception& e) {
    return refuse(request, http::status::internal_server_error, e.what());
  }
}

std::optional<int> layer_of(const std::string& text) {
  if (text.empty() || text.size() > 7 || text.find_first_not_of("0123456789") != text.npos)
    return std::nullopt;
  return std::stoi(text);
}

Response Server::answer_api(const Request& request, const std::vector<std::string>& parts) {
  if (parts.size() == 4 && parts[3] == "notes" && request.method() == http::verb::post)
    return take_notes(request, parts[2]);
  if (request.method() != http::verb::get)
    return refuse(request, http::status::method_not_allowed, "only GET, and POST of notes");
  if (parts.size() == 2) return reply(request, http::status::ok, "application/json", runs_.list_json());
  if (parts.size() == 4 && parts[3] == "report") {
    const auto folder = runs_.find(parts[2]);
    if (!folder || !fs::is_regular_file(*folder / "report.html"))
      return refuse(request, http::status::not_found, "there is no report: firn report RUN writes one");
    Response r =
        reply(request, http::status::ok, "text/html; charset=utf-8", read_file(*folder / "report.html"));
    r.set("Content-Security-Policy", "sandbox; default-src 'none'; style-src 'unsafe-inline'; img-src data:");
    return r;
  }
  const auto run = runs_.open(parts[2], steady_s());
  if (!run)
    return refuse(request, http::status::not_found, "there is no run '" + parts[2].substr(0, 100) + "'");
  look(run);
  if (parts.size() == 3) return reply(request, http::status::ok, "application/json", run->hello(steady_s()));
  const auto surface = parts.size() == 6 && parts[3] == "layers" ? surface_of(parts[5]) : std::nullopt;
  const auto layer = surface ? layer_of(parts[4]) : std::nullopt;
  const auto map = layer ? run->map({*surface, *layer}) : std::nullopt;
  if (!map) return refuse(request, http::status::not_found, "the run has no such map");
  return reply(request, http::status::ok, "application/octet-stream",
               {reinterpret_cast<const char*>(map->data()), map->size()});
}

Response Server::take_notes(const Request& request, const std::string& id) try {
  if (!to_string(request[http::field::content_type]).starts_with("application/json"))
    return refuse(request, http::status::unsupported_media_type, "Content-Type must be application/json");
  std::string token;
  const Notes notes = parse_notes(request.body(), &token);
  if (options_.token.empty() || !same_secret(token, options_.token))
    return refuse(request, http::status::forbidden,
                  "the token is missing or wrong: it stands in the address that the terminal shows");
  const auto folder = runs_.find(id);
  if (!folder) return refuse(request, http::status::not_found, "there is no run '" + id.substr(0, 100) + "'");
  write_notes(*folder, notes);
  return reply(request, http::status::ok, "application/json", "{\"ok\":true}");
} catch (const std::invalid_argument& e) {
  return refuse(request, http::status::bad_request, e.what());
}

}  // namespace

void serve(const ServerOptions& options) { Server(options).run(); }

}  // namespace firn::page
