// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/message_traits.h>
#include <ros/serialization.h>

#include <cstring>
#include <string>
#include <type_traits>

namespace lidard {

/// Properties of a message type that roscpp and rosbag need.
struct MessageType {
  std::string name, md5;
  /// Without comments, in the form of `gendeps --cat`: rosbag stores it, so that messages can be read without
  /// the package.
  std::string definition;
  bool begins_with_header = false;  ///< roscpp numbers such messages
};

/// A serialised message of any type. Everything is published and written into bags as such messages, so that
/// the templates of roscpp and rosbag are instantiated once.
struct RawMessage {
  const MessageType* type = nullptr;
  ros::SerializedMessage data = {};

  std::uint32_t size() const {
    return static_cast<std::uint32_t>(data.buf.get() + data.num_bytes - data.message_start);
  }
};

/// The base of a message of a package that Debian does not have, so that the package is not needed to build.
/// Has a `static const MessageType& message_type()`, and all(stream), which writes or measures the message.
struct CarriedMessage {};

/// A part of a definition in the form of `gendeps --cat`: the definition of a message that others contain.
inline std::string definition_part(const std::string& type, const std::string& text) {
  return std::string(80, '=') + "\nMSG: " + type + "\n" + text;
}

template <class Message>
const MessageType& type_of() {
  namespace traits = ros::message_traits;
  if constexpr (std::is_base_of_v<CarriedMessage, Message>) {
    return Message::message_type();
  } else {
    static const MessageType type{traits::datatype<Message>(), traits::md5sum<Message>(),
                                  traits::definition<Message>(), traits::hasHeader<Message>()};
    return type;
  }
}

template <class Message>
RawMessage raw(const Message& message) {
  namespace wire = ros::serialization;
  if constexpr (std::is_base_of_v<CarriedMessage, Message>) {
    wire::LStream measure;
    message.all(measure);
    const std::uint32_t length = measure.getLength();
    // On the wire the length comes first.
    ros::SerializedMessage data(boost::shared_array<std::uint8_t>(new std::uint8_t[length + 4]), length + 4);
    wire::OStream stream(data.buf.get(), length + 4);
    stream.next(length);
    data.message_start = stream.getData();
    message.all(stream);
    return {&type_of<Message>(), data};
  } else {
    return {&type_of<Message>(), wire::serializeMessage(message)};
  }
}

}  // namespace lidard

namespace ros::message_traits {

template <>
struct MD5Sum<lidard::RawMessage> {
  static const char* value() { return "*"; }
  static const char* value(const lidard::RawMessage& message) { return message.type->md5.c_str(); }
};

template <>
struct DataType<lidard::RawMessage> {
  static const char* value() { return "*"; }
  static const char* value(const lidard::RawMessage& message) { return message.type->name.c_str(); }
};

template <>
struct Definition<lidard::RawMessage> {
  static const char* value() { return ""; }
  static const char* value(const lidard::RawMessage& message) { return message.type->definition.c_str(); }
};

}  // namespace ros::message_traits

namespace ros::serialization {

template <>
struct Serializer<lidard::RawMessage> {
  template <typename Stream>
  static void read(Stream& stream, lidard::RawMessage& message) {
    const std::uint32_t length = stream.getLength();
    message.data = SerializedMessage(boost::shared_array<std::uint8_t>(new std::uint8_t[length]), length);
    message.data.message_start = message.data.buf.get();
    std::memcpy(message.data.message_start, stream.advance(length), length);
  }
  template <typename Stream>
  static void write(Stream& stream, const lidard::RawMessage& message) {
    std::memcpy(stream.advance(message.size()), message.data.message_start, message.size());
  }
  static std::uint32_t serializedLength(const lidard::RawMessage& message) { return message.size(); }
};

}  // namespace ros::serialization
