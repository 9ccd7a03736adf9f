// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/message_traits.h>
#include <ros/serialization.h>

#include <cstdint>
#include <string>

namespace lidard {

/// A message of a package that Debian does not have, so that the package is not needed to build. `Form` has
/// its members and these constants: `type`, `md5`, `begins_with_header`; definition() gives the definition
/// without comments, which the MD5 leaves out, in the form of `gendeps --cat`: rosbag keeps it, and whoever
/// does not have the package reads the messages by it. all(stream, form) reads, writes or measures the
/// message, as the stream asks for.
template <class Form>
struct CarriedMessage : Form {};

/// A part of a definition in the form of `gendeps --cat`: the definition of a message that others contain.
inline std::string definition_part(const std::string& type, const std::string& text) {
  return std::string(80, '=') + "\nMSG: " + type + "\n" + text;
}

}  // namespace lidard

namespace ros::message_traits {

template <class Form>
struct MD5Sum<lidard::CarriedMessage<Form>> {
  static const char* value() { return Form::md5; }
  static const char* value(const lidard::CarriedMessage<Form>&) { return value(); }
};

template <class Form>
struct DataType<lidard::CarriedMessage<Form>> {
  static const char* value() { return Form::type; }
  static const char* value(const lidard::CarriedMessage<Form>&) { return value(); }
};

template <class Form>
struct Definition<lidard::CarriedMessage<Form>> {
  static const char* value() {
    static const std::string text = Form::definition();
    return text.c_str();
  }
  static const char* value(const lidard::CarriedMessage<Form>&) { return value(); }
};

/// roscpp numbers messages that begin with a header.
template <class Form>
struct HasHeader<lidard::CarriedMessage<Form>>
    : std::conditional_t<Form::begins_with_header, TrueType, FalseType> {};

}  // namespace ros::message_traits

namespace ros::serialization {

template <class Form>
struct Serializer<lidard::CarriedMessage<Form>> {
  template <typename Stream>
  static void read(Stream& stream, lidard::CarriedMessage<Form>& message) {
    Form::all(stream, message);
  }
  template <typename Stream>
  static void write(Stream& stream, const lidard::CarriedMessage<Form>& message) {
    Form::all(stream, message);
  }
  static std::uint32_t serializedLength(const lidard::CarriedMessage<Form>& message) {
    LStream stream;
    Form::all(stream, message);
    return stream.getLength();
  }
};

}  // namespace ros::serialization
