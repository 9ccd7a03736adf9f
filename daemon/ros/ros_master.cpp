// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/ros_master.h"

#include <ros/network.h>
#include <ros/publication.h>
#include <ros/this_node.h>
#include <ros/topic_manager.h>
#include <ros/xmlrpc_manager.h>

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <charconv>
#include <utility>

namespace lidard {
namespace {

using XmlRpc::XmlRpcValue;

std::vector<std::string> strings(XmlRpcValue& list) {
  std::vector<std::string> found;
  if (list.getType() != XmlRpcValue::TypeArray) return found;
  for (int i = 0; i < list.size(); ++i) {
    if (list[i].getType() == XmlRpcValue::TypeString) found.push_back(static_cast<std::string&>(list[i]));
  }
  return found;
}

/// Where roscpp answers in this process.
std::string our_uri() { return ros::XMLRPCManager::instance()->getServerURI(); }

std::string request_body(const std::string& method, const XmlRpc::XmlRpcValue& arguments) {
  std::string body = "<?xml version=\"1.0\"?><methodCall><methodName>" + method + "</methodName><params>";
  for (int i = 0; i < arguments.size(); ++i) body += "<param>" + arguments[i].toXml() + "</param>";
  return body + "</params></methodCall>";
}

std::optional<XmlRpc::XmlRpcValue> answer(const std::string& body, std::string& error) {
  const auto begin = body.find("<value>");
  if (begin == std::string::npos || body.find("<fault>") != std::string::npos) {
    error = "the answer is a fault";
    return std::nullopt;
  }
  int offset = static_cast<int>(begin);
  XmlRpc::XmlRpcValue value(body, &offset);
  if (!value.valid()) {
    error = "the answer is not XML-RPC";
    return std::nullopt;
  }
  return value;
}

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using asio::ip::tcp;

/// RFC 3986, section 3.2.2: an IPv6 address stands in brackets.
std::string host_field(const XmlRpcServer& server) {
  const std::string host = server.host.find(':') == std::string::npos ? server.host : "[" + server.host + "]";
  return server.port == 80 ? host : host + ":" + std::to_string(server.port);
}

/// One POST on a connection of its own. Each step starts the next; the stream's time limit ends whatever
/// takes too long.
class Exchange {
 public:
  Exchange(asio::io_context& io, const XmlRpcServer& server, std::string body, Span limit)
      : resolver_(io), stream_(io), limit_(limit), request_(http::verb::post, "/RPC2", 11, std::move(body)) {
    request_.set(http::field::host, host_field(server));
    request_.set(http::field::content_type, "text/xml");
    request_.keep_alive(false);
    request_.prepare_payload();
    // A literal address needs no resolver, whose thread cannot be interrupted.
    beast::error_code no_address;
    const auto address = asio::ip::make_address(server.host, no_address);
    if (!no_address) {
      connect(tcp::resolver::results_type::create({address, server.port}, "", ""));
      return;
    }
    resolver_.async_resolve(server.host, std::to_string(server.port),
                            [this](beast::error_code error, const tcp::resolver::results_type& found) {
                              if (!failed(error)) connect(found);
                            });
  }
  /// The body of the answer; empty, with the reason in `error`, where there is none with status 200 in time.
  std::string body(std::string& error) {
    if (error_)
      error = error_ == beast::error::timeout ? "no answer in time" : error_.message();
    else if (response_.result() != http::status::ok)
      error = "HTTP status " + std::to_string(response_.result_int());
    else
      return std::move(response_.body());
    return {};
  }

 private:
  void connect(const tcp::resolver::results_type& found) {
    stream_.expires_after(limit_);
    stream_.async_connect(found, [this](beast::error_code error, const tcp::endpoint&) {
      if (!failed(error)) write();
    });
  }
  void write() {
    http::async_write(stream_, request_, [this](beast::error_code error, std::size_t) {
      if (!failed(error)) read();
    });
  }
  void read() {
    http::async_read(stream_, buffer_, response_,
                     [this](beast::error_code error, std::size_t) { failed(error); });
  }
  bool failed(beast::error_code error) {
    error_ = error;
    return static_cast<bool>(error);
  }

  tcp::resolver resolver_;
  beast::tcp_stream stream_;
  Span limit_;
  http::request<http::string_body> request_;
  http::response<http::string_body> response_;
  beast::flat_buffer buffer_;
  beast::error_code error_;
};

}  // namespace

MasterClient::MasterClient(XmlRpcServer server, std::string caller_id, Span limit)
    : server_(std::move(server)), caller_id_(std::move(caller_id)), limit_(limit) {}

std::optional<XmlRpcValue> MasterClient::call(const std::string& method,
                                              const std::vector<std::string>& arguments) {
  XmlRpcValue list;
  list[0] = caller_id_;
  for (std::size_t i = 0; i < arguments.size(); ++i) list[static_cast<int>(i + 1)] = arguments[i];
  return ask(method, list);
}

std::optional<XmlRpcValue> MasterClient::ask(const std::string& method, const XmlRpcValue& arguments) {
  auto answer = xmlrpc_call(server_, method, arguments, limit_, error_);
  if (!answer) return std::nullopt;
  // Every answer of the master is [code, message, value]; code 1 is success (Master API).
  if (answer->getType() != XmlRpcValue::TypeArray || answer->size() != 3 ||
      (*answer)[0].getType() != XmlRpcValue::TypeInt || static_cast<int&>((*answer)[0]) != 1) {
    error_ = method + ": the master refused";
    return std::nullopt;
  }
  return XmlRpcValue((*answer)[2]);
}

std::optional<int> MasterClient::pid() {
  auto value = call("getPid", {});
  if (!value || value->getType() != XmlRpcValue::TypeInt) return std::nullopt;
  return static_cast<int&>(*value);
}

bool MasterClient::register_publisher(const std::string& topic, const std::string& type) {
  return call("registerPublisher", {topic, type, our_uri()}).has_value();
}

bool MasterClient::register_service(const std::string& service, std::uint32_t port) {
  const std::string service_uri = "rosrpc://" + ros::network::getHost() + ":" + std::to_string(port);
  return call("registerService", {service, service_uri, our_uri()}).has_value();
}

bool MasterClient::register_subscriber(const std::string& topic) {
  auto publishers = call("registerSubscriber", {topic, "*", our_uri()});
  const auto us = parse_server_uri(our_uri());
  if (!publishers || !us) return publishers.has_value();
  if (publishers->getType() != XmlRpcValue::TypeArray || publishers->size() == 0) return true;
  XmlRpcValue arguments;
  arguments[0] = caller_id_;
  arguments[1] = topic;
  arguments[2] = *publishers;
  std::string error;
  xmlrpc_call(*us, "publisherUpdate", arguments, std::chrono::milliseconds(500), error);
  return true;
}

std::optional<std::string> MasterClient::node_uri(const std::string& node) {
  auto value = call("lookupNode", {node});
  if (!value || value->getType() != XmlRpcValue::TypeString) return std::nullopt;
  return static_cast<std::string&>(*value);
}

std::map<std::string, std::string> MasterClient::topic_types() {
  std::map<std::string, std::string> types;
  auto value = call("getTopicTypes", {});
  if (!value || value->getType() != XmlRpcValue::TypeArray) return types;
  for (int i = 0; i < value->size(); ++i) {
    const auto pair = strings((*value)[i]);
    if (pair.size() == 2) types[pair[0]] = pair[1];
  }
  return types;
}

std::optional<XmlRpcValue> MasterClient::parameters(const std::string& name) {
  // getParam refuses what is not there as it refuses what is wrong.
  auto there = call("hasParam", {name});
  if (!there || there->getType() != XmlRpcValue::TypeBoolean) return std::nullopt;
  if (!static_cast<bool&>(*there)) {
    XmlRpcValue none;
    none.begin();  // makes it a struct
    return none;
  }
  return call("getParam", {name});
}

bool MasterClient::set_parameter(const std::string& name, const XmlRpcValue& value) {
  XmlRpcValue arguments;
  arguments[0] = caller_id_;
  arguments[1] = name;
  arguments[2] = value;
  return ask("setParam", arguments).has_value();
}

bool register_again(MasterClient& master, const std::vector<std::string>& services, std::uint32_t port) {
  ros::V_string published;
  ros::V_string subscribed;
  ros::this_node::getAdvertisedTopics(published);
  ros::this_node::getSubscribedTopics(subscribed);
  bool all = true;
  for (const auto& topic : published) {
    const auto publication = ros::TopicManager::instance()->lookupPublication(topic);
    if (publication) all &= master.register_publisher(topic, publication->getDataType());
  }
  for (const auto& topic : subscribed) all &= master.register_subscriber(topic);
  // roscpp offers these two for every node.
  for (const char* name : {"/get_loggers", "/set_logger_level"})
    all &= master.register_service(master.caller_id() + name, port);
  for (const auto& service : services) all &= master.register_service(service, port);
  return all;
}

std::optional<XmlRpcServer> parse_server_uri(const std::string& uri) {
  const std::string scheme = "http://";
  if (uri.compare(0, scheme.size(), scheme) != 0) return std::nullopt;
  std::string rest = uri.substr(scheme.size());
  if (!rest.empty() && rest.back() == '/') rest.pop_back();
  const auto colon = rest.rfind(':');
  if (colon == std::string::npos || colon == 0) return std::nullopt;
  XmlRpcServer server{rest.substr(0, colon), 0};
  const char* end = rest.data() + rest.size();
  const auto parsed = std::from_chars(rest.data() + colon + 1, end, server.port);
  if (parsed.ec != std::errc() || parsed.ptr != end || server.port == 0) return std::nullopt;
  return server;
}

std::optional<XmlRpc::XmlRpcValue> xmlrpc_call(const XmlRpcServer& server, const std::string& method,
                                               const XmlRpc::XmlRpcValue& arguments, Span limit,
                                               std::string& error) {
  error.clear();
  asio::io_context io{1};
  Exchange exchange(io, server, request_body(method, arguments), limit);
  io.run();
  const std::string got = exchange.body(error);
  if (!error.empty()) return std::nullopt;
  return answer(got, error);
}

}  // namespace lidard
