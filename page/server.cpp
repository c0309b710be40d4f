#include "page/server.h"

#include <sys/resource.h>
#include <unistd.h>

#include <utility>  // before boost/asio/awaitable.hpp, which takes it for granted

#include <atomic>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/this_coro.hpp>
#include <boost/asio/thread_pool.hpp>
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
#include <sstream>
#include <stdexcept>

#include "page/access.h"
#include "page/answers.h"
#include "page/api_v1.h"
#include "page/client_frame.h"
#include "page/command_thread.h"
#include "page/idle_places.h"
#include "page/listening.h"
#include "page/view_json.h"
#include "page/web_rules.h"
#include "runs/folder/address.h"
#include "runtime/run_clock.h"

namespace firn::page {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace fs = std::filesystem;
using asio::ip::tcp;
using namespace std::chrono_literals;

constexpr std::chrono::seconds kPatience{10};  // for a request, for an answer to an order
constexpr auto kTick = 25ms;
constexpr auto kMapPause = 100ms;                               // between two maps that are being measured
constexpr auto kStatePause = 250ms;                             // between two states without an event
constexpr std::size_t kMaxWaitingBytes = std::size_t(4) << 20;  // of text for one tab
constexpr int kSocketBuffer = 1 << 19;                          // so much of a map may wait in the kernel
constexpr int kNice = 10;
constexpr std::uint32_t kMaxHeadBytes = 8192;
constexpr std::uint64_t kMaxBodyBytes = kMaxNotesBytes + 1024;  // notes with their token
constexpr std::size_t kMaxUnreadBytes = std::size_t(1) << 22;   // of a request that is too long

template <class T>
using Shared = std::shared_ptr<const T>;
using Bytes = std::vector<std::byte>;

double steady_s() { return double(monotonic_ns()) * 1e-9; }

using Request = http::request<http::string_body>;
using Response = http::response<http::string_body>;
using Socket = beast::websocket::stream<beast::tcp_stream>;
std::string to_string(beast::string_view text) { return {text.data(), text.size()}; }
void make_ready(Socket& socket) {
  socket.set_option(beast::websocket::stream_base::timeout{kPatience, 60s, true});
  socket.read_message_max(kMaxFrameBytes);
  socket.auto_fragment(false);
}

// One browser's WebSocket. It reads as fast as it likes: text waits up to a limit, of maps only the newest.
class Tab : public std::enable_shared_from_this<Tab> {
 public:
  explicit Tab(tcp::socket socket) : socket_(std::move(socket)) {}

  Socket& socket() { return socket_; }
  void push(Shared<std::string> text) {
    waiting_bytes_ += text->size();
    if (waiting_bytes_ > kMaxWaitingBytes) return close();
    texts_.push_back(std::move(text));
    write_next();
  }
  void push(const std::string& text) { push(std::make_shared<const std::string>(text)); }
  void push_map(Shared<Bytes> map) {
    map_ = std::move(map);
    write_next();
  }
  void close() {
    boost::system::error_code ignored;
    beast::get_lowest_layer(socket_).socket().close(ignored);
  }

  bool busy() const { return writing_; }
  std::shared_ptr<WatchedRun> run;
  Person by_header;  // whose it is, without cookies
  std::optional<Surface> follows;
  std::uint64_t rows_seen = 0;  // of the rows that are measured now

 private:
  void write_next() {
    if (writing_ || (texts_.empty() && !map_)) return;
    writing_ = true;
    const auto done = [self = shared_from_this()](boost::system::error_code error, std::size_t) {
      self->writing_ = false;
      self->map_in_flight_.reset();
      if (!error) self->write_next();
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
  Shared<Bytes> map_, map_in_flight_;
};

// GCC 12 destroys temporaries of a co_await expression twice: each awaited object has a name.
class Server {
 public:
  Server(const Product& product, const ServerOptions& options)
      : product_(product),
        options_(options),
        runs_(options.places, options.live, options.live.empty() ? options.index : runs::user_index()),
        access_(options),
        answers_(product, options, runs_, access_),
        acceptor_(io_),
        timer_(io_),
        gives_way_(!options.live.empty()) {}

  void run() {
    listen();
    give_way();
    asio::co_spawn(io_, accept(), asio::detached);
    asio::co_spawn(io_, watch(), asio::detached);
    std::optional<asio::posix::stream_descriptor> stop;
    if (options_.stop_fd >= 0) {
      stop.emplace(io_, ::dup(options_.stop_fd));
      stop->async_wait(asio::posix::stream_descriptor::wait_read, [this](auto) { io_.stop(); });
    }
    run_through([this] { io_.run(); });
  }

 private:
  void listen();
  asio::awaitable<void> accept();
  asio::awaitable<void> serve(tcp::socket socket);
  asio::awaitable<void> serve_tab(tcp::socket socket, Request request);
  asio::awaitable<void> watch();
  asio::awaitable<WebReply> answer(const WebRequest& request);
  asio::awaitable<std::shared_ptr<WatchedRun>> open(const std::string& id);
  std::string foreign(const Request& request) const;  // why it is refused; "" = it is not
  WebRequest as_web_request(Request&& request);
  bool take_line(beast::tcp_stream& stream, const Request& request);
  void take(const std::shared_ptr<Tab>& tab, std::string_view text);
  void follow(const std::shared_ptr<Tab>& tab, const ClientFrame& frame);
  void look(const std::shared_ptr<WatchedRun>& run);
  void give_way() const {  // of one thread, once a print runs
    if (gives_way_) ::setpriority(PRIO_PROCESS, 0, kNice);
  }
  /// Returns the result of `work`, done by a thread that reads runs: a report delays no other run.
  template <class Work>
  auto apart(Work work) -> asio::awaitable<decltype(work())> {
    auto yielding = [this, work] {
      give_way();
      return work();
    };
    return on(reader_, std::move(yielding));
  }
  template <class Work>
  auto on(asio::thread_pool& pool, Work work) -> asio::awaitable<decltype(work())> {
    auto body = [work]() -> asio::awaitable<decltype(work())> { co_return work(); };
    auto done = asio::co_spawn(pool, std::move(body), asio::use_awaitable);
    co_return co_await std::move(done);
  }
  void send_maps(WatchedRun& run);
  void send_rows();

  const Product& product_;
  const ServerOptions& options_;
  RunSet runs_;
  Access access_;
  Answers answers_;
  CommandThread commands_;  // before this thread gives way
  IdlePlaces idle_;         // goes after io_, whose connections have places in it
  asio::io_context io_{1};
  asio::thread_pool starter_{1};  // of prints, which have its priority: it begins before others give way
  asio::thread_pool reader_{2};   // goes first: its objects belong to io_
  tcp::acceptor acceptor_;
  asio::steady_timer timer_;
  std::atomic<bool> gives_way_;
  std::vector<std::string> own_;
  std::set<std::shared_ptr<Tab>> tabs_;
  std::set<fs::path> troubled_, opening_;
  int connections_ = 0;
  std::chrono::steady_clock::time_point last_state_{}, last_rows_{};
};

void Server::listen() {
  const Listening l = listen_on(options_.bind, options_.port);
  acceptor_.assign(l.v6 ? tcp::v6() : tcp::v4(), l.fd);
  own_ = own_authorities(options_.bind, l.port, options_.hosts);
  if (options_.listening) options_.listening(l.address);
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
    if (connections_ >= kMaxConnections && !idle_.make_room()) continue;  // closes it
    socket.set_option(tcp::no_delay(true), error);
    socket.set_option(asio::socket_base::send_buffer_size(kSocketBuffer), error);
    ++connections_;
    asio::co_spawn(io_, serve(std::move(socket)), [this](const std::exception_ptr&) { --connections_; });
  }
}

std::string Server::foreign(const Request& request) const {
  return foreign_words(to_string(request[http::field::host]), to_string(request[http::field::origin]), own_);
}

ShownRights shown_by(const Request& request) {
  return {to_string(request[http::field::authorization]), to_string(request[http::field::cookie]),
          to_string(request["X-Forwarded-User"])};
}

WebRequest Server::as_web_request(Request&& request) {
  WebRequest r;
  const ShownRights shown = shown_by(request);
  r.person = access_.of(shown);
  r.by_header = access_.by_header(shown);
  r.method = to_string(request.method_string());
  r.target = to_string(request.target());
  r.type = to_string(request[http::field::content_type]);
  r.if_none_match = to_string(request[http::field::if_none_match]);
  r.gzip = to_string(request[http::field::accept_encoding]).find("gzip") != std::string::npos;
  r.body = std::move(request.body());
  return r;
}

Response as_response(WebReply&& reply, unsigned version, bool keep_alive, bool head) {
  Response r(http::int_to_status(unsigned(reply.status)), version);
  r.set(http::field::content_type, reply.type);
  r.set(http::field::cache_control, reply.etag.empty() ? "no-store" : "no-cache");
  if (!reply.etag.empty()) r.set(http::field::etag, reply.etag);
  if (reply.packed) r.set(http::field::content_encoding, "gzip");
  for (const auto& [name, value] : safety_headers(reply)) r.set(name, value);
  r.keep_alive(keep_alive);
  if (!head) r.body() = std::move(reply.body);
  if (reply.status != 204) r.prepare_payload();  // which has no length [RFC 9110, 8.6]
  return r;
}

// The rest of the request is read for a while: a connection that is closed before loses the answer.
asio::awaitable<void> refuse_rest(beast::tcp_stream& stream, WebReply why) {
  Response response = as_response(std::move(why), 11, false, false);
  stream.expires_after(kPatience);
  co_await http::async_write(stream, response, asio::use_awaitable);
  boost::system::error_code ended;
  stream.socket().shutdown(tcp::socket::shutdown_send, ended);
  std::vector<char> rest(1 << 16);
  for (std::size_t read = 0; !ended && read < kMaxUnreadBytes;)
    read +=
        co_await stream.async_read_some(asio::buffer(rest), asio::redirect_error(asio::use_awaitable, ended));
}

asio::awaitable<void> Server::serve(tcp::socket socket) {
  boost::system::error_code ignored;
  const std::string from = socket.remote_endpoint(ignored).address().to_string();
  beast::tcp_stream stream(std::move(socket));
  beast::flat_buffer buffer(1 << 16);
  for (bool go_on = true; go_on;) {
    http::request_parser<http::string_body> parser;
    parser.header_limit(kMaxHeadBytes);
    parser.body_limit(kMaxBodyBytes);
    stream.expires_after(kPatience);
    boost::system::error_code ended;
    {
      const IdlePlaces::Place place = idle_.enter(from, [&stream] { stream.close(); });
      co_await http::async_read(stream, buffer, parser, asio::redirect_error(asio::use_awaitable, ended));
    }
    if (ended == http::error::body_limit || ended == http::error::header_limit) {
      WebReply told = ended == http::error::body_limit
                          ? refusal(413, "a body has at most " + std::to_string(kMaxBodyBytes) + " bytes")
                          : refusal(431, "the head has at most " + std::to_string(kMaxHeadBytes) + " bytes");
      auto refusing = refuse_rest(stream, std::move(told));
      co_await std::move(refusing);
      co_return;
    }
    if (ended) co_return;  // it has gone, or sent no HTTP
    Request request = parser.release();
    if (beast::websocket::is_upgrade(request) && foreign(request).empty()) {
      stream.expires_never();
      if (take_line(stream, request)) co_return;
      const bool to_a_run = is_websocket_target(to_string(request.target()));
      if (to_a_run && access_.of(shown_by(request)).reads)
        co_return co_await serve_tab(stream.release_socket(), std::move(request));
    }
    const unsigned version = request.version();
    const bool head = request.method() == http::verb::head;
    go_on = request.keep_alive();
    WebReply reply = refusal(403, foreign(request));
    const bool of_runs = request.target().starts_with("/api/") || request.target() == "/metrics" ||
                         beast::websocket::is_upgrade(request);
    if (foreign(request).empty() && of_runs && !access_.of(shown_by(request)).reads) {
      reply = refusal(401, std::string(kNoToken));
    } else if (foreign(request).empty()) {
      const WebRequest asked = as_web_request(std::move(request));
      reply = co_await answer(asked);
    }
    Response response = as_response(std::move(reply), version, go_on, head);
    stream.expires_after(kPatience);
    co_await http::async_write(stream, response, asio::use_awaitable);
  }
  stream.socket().shutdown(tcp::socket::shutdown_send, ignored);
}

// "/command?run=ID" is a line for commands alone; the token comes as a protocol, which no log shows.
bool Server::take_line(beast::tcp_stream& stream, const Request& request) {
  const std::string target = to_string(request.target());
  if (!target.starts_with("/command?")) return false;
  const std::string header = to_string(request[http::field::sec_websocket_protocol]);
  const auto words = list_words(header);
  if (words.empty() || words.size() > 2 || words[0] != CommandThread::kProtocol) return false;
  const Person person = words.size() == 2 ? access_.of_token(words[1]) : access_.by_header(shown_by(request));
  if (!person.commands) return false;
  const auto folder = runs_.find(run_of(target));
  if (!folder) return false;
  boost::system::error_code gone;
  tcp::socket socket = stream.release_socket();
  const bool v6 = socket.local_endpoint(gone).protocol() == tcp::v6();
  const int fd = gone ? -1 : socket.release(gone);
  std::ostringstream text;
  text << request;
  if (!gone) commands_.take(fd, v6, text.str(), {*folder, runs::address_of(*folder).run_id, person.name});
  return true;
}

asio::awaitable<WebReply> Server::answer(const WebRequest& given) {
  std::optional<std::string> target = without_version(given.method, given.target);
  if (!target) co_return refusal(404, "version 1 has no such request; docs/openapi.json has all of them");
  WebRequest request = given;
  request.target = std::move(*target);
  const auto parts = path_parts(request.target);
  if (auto slow = answers_.slow_answer(request, parts)) {
    auto reply = apart(std::move(slow));
    co_return co_await std::move(reply);
  }
  if (auto resume = answers_.resume(request, parts)) {
    auto reply = on(starter_, std::move(resume));
    co_return co_await std::move(reply);
  }
  if (const std::string id = Answers::wanted_run(parts); !id.empty()) {
    std::string trouble;
    try {
      if (const auto run = co_await open(id)) look(run);
    } catch (const std::exception& e) {
      trouble = e.what();
    }
    if (!trouble.empty()) co_return refusal(500, trouble);
  }
  co_return answers_.answer(request, parts, steady_s());
}

asio::awaitable<std::shared_ptr<WatchedRun>> Server::open(const std::string& id) {
  const auto folder = runs_.find(id);
  if (!folder) co_return nullptr;
  for (;;) {
    if (auto run = runs_.opened(id)) co_return run;
    if (opening_.insert(*folder).second) break;
    asio::steady_timer pause(io_, kTick / 5);
    co_await pause.async_wait(asio::use_awaitable);
  }
  std::shared_ptr<WatchedRun> run;
  std::exception_ptr trouble;
  try {
    auto reading =
        apart([this, at = *folder] { return std::make_shared<WatchedRun>(product_, at, steady_s()); });
    run = co_await std::move(reading);
    runs_.keep(run);
    if (run->live()) gives_way_ = true;
    give_way();
  } catch (...) {
    trouble = std::current_exception();
  }
  opening_.erase(*folder);
  if (trouble) std::rethrow_exception(trouble);
  co_return run;
}

asio::awaitable<void> Server::serve_tab(tcp::socket socket, Request request) {
  const auto tab = std::make_shared<Tab>(std::move(socket));
  Socket& ws = tab->socket();
  make_ready(ws);
  co_await ws.async_accept(request, asio::use_awaitable);
  const std::string id = websocket_run(to_string(request.target()));
  const Reader reader = reader_of(access_.of(shown_by(request)), access_.by_header(shown_by(request)));
  tab->by_header = access_.by_header(shown_by(request));
  std::string trouble = "no run '" + id.substr(0, 100) + "', or several of this name";
  try {
    tab->run = co_await open(id);
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
  tab->push(tab->run->hello(steady_s(), runs_.label(tab->run->folder()), answers_.may_resume(), reader));
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
  const Person person = frame.token.empty() ? tab->by_header : access_.of_token(frame.token);
  if (!person.commands) return tab->push(answer_frame(frame.id, false, no_command_words(person), ""));
  commands_.obey({tab->run->folder(), tab->run->run_id(), person.name}, std::move(frame),
                 [this, tab](std::string answer) {
                   asio::post(io_, [tab, answer = std::move(answer)] { tab->push(answer); });
                 });
}

void Server::follow(const std::shared_ptr<Tab>& tab, const ClientFrame& frame) {
  if (!frame.layer) tab->follows = frame.surface;
  if (!frame.layer) tab->rows_seen = 0;
  if (!frame.surface) return;
  const auto layer = frame.layer ? frame.layer : tab->run->newest_layer();
  auto map = layer ? tab->run->map({*frame.surface, *layer}) : std::nullopt;
  if (map) return tab->push_map(std::make_shared<const Bytes>(std::move(*map)));
  if (frame.layer)
    tab->push(answer_frame(std::nullopt, false,
                           "layer " + std::to_string(*frame.layer) + " has no map '" +
                               std::string(word_of(*frame.surface)) + "'",
                           ""));
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
    const auto now = std::chrono::steady_clock::now();
    if (now >= last_rows_ + kMapPause) {
      last_rows_ = now;
      send_rows();
    }
    if (now < last_state_ + kStatePause) continue;
    last_state_ = now;
    if (const auto work = runs_.error_to_read()) asio::co_spawn(io_, apart(work), asio::detached);
    std::map<WatchedRun*, Shared<std::string>> made;  // one for all tabs
    for (const auto& tab : std::set(tabs_)) {
      if (!tab->run->live()) continue;
      auto& state = made[tab->run.get()];
      if (!state) state = std::make_shared<const std::string>(tab->run->state(steady_s()));
      tab->push(state);
    }
  }
}

void Server::look(const std::shared_ptr<WatchedRun>& run) {
  const WatchedRun::News news = run->poll(steady_s());
  for (const std::string& frame : news.frames) {
    const auto shared = std::make_shared<const std::string>(frame);
    for (const auto& tab : std::set(tabs_))  // a tab that is too slow is closed on the way
      if (tab->run == run) tab->push(shared);
  }
  if (news.map) send_maps(*run);
}

void Server::send_maps(WatchedRun& run) {
  std::map<Surface, Shared<Bytes>> made;  // one for all tabs
  for (const auto& tab : tabs_) {
    if (tab->run.get() != &run || !tab->follows) continue;
    auto& map = made[*tab->follows];
    if (!map) {
      auto frame = run.map({*tab->follows, run.newest_layer().value_or(0)});
      if (!frame) continue;
      map = std::make_shared<const Bytes>(std::move(*frame));
    }
    tab->push_map(map);
  }
}

// A tab that still receives earlier rows gets the rows of both times later.
void Server::send_rows() {
  std::map<std::pair<WatchedRun*, std::uint64_t>, Shared<Bytes>> made;
  for (const auto& tab : tabs_) {
    const std::uint64_t stamp = tab->run->rows_stamp();
    if (tab->follows != Surface::kMeasured || tab->rows_seen >= stamp || tab->busy()) continue;
    auto& rows = made[{tab->run.get(), tab->rows_seen}];
    if (!rows) rows = std::make_shared<const Bytes>(tab->run->partial_map(tab->rows_seen).value_or(Bytes()));
    tab->rows_seen = stamp;
    tab->push_map(rows);
  }
}

}  // namespace

void serve(const Product& product, const ServerOptions& options) { Server(product, options).run(); }

}  // namespace firn::page
