// Wrenches to and odometry from ROS 2 on the wire, by Cyclone DDS, for Python's ctypes.
#include <dds/dds.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "ros2_messages.h"

typedef geometry_msgs_msg_dds__WrenchStamped_ Wrench;
typedef nav_msgs_msg_dds__Odometry_ Odometry;
typedef void (*Act)(const double*);

enum { kDepth = 10 };  // of queues

static dds_entity_t domain(void) {
  static dds_entity_t made = 0;
  if (made == 0) {
    made = dds_create_participant((dds_domainid_t)atoi(getenv("ROS_DOMAIN_ID")), NULL, NULL);
  }
  return made;
}

static dds_qos_t* quality(void) {
  const dds_data_representation_id_t format = DDS_DATA_REPRESENTATION_XCDR1;
  dds_qos_t* made = dds_create_qos();
  dds_qset_reliability(made, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_history(made, DDS_HISTORY_KEEP_LAST, kDepth);
  dds_qset_data_representation(made, 1, &format);
  return made;
}

static dds_entity_t topic_of(const dds_topic_descriptor_t* kind, const char* name,
                             const dds_qos_t* how) {
  char full[256];
  (void)snprintf(full, sizeof full, "rt%s", name);
  return dds_create_topic(domain(), kind, full, how, NULL);
}

/// Writer of a topic of wrenches; NULL: there is none.
void* sync_publisher(const char* topic, bool is_wrench) {
  if (!is_wrench) return NULL;
  dds_qos_t* how = quality();
  const dds_entity_t of = topic_of(&geometry_msgs_msg_dds__WrenchStamped__desc, topic, how);
  const dds_entity_t writer = dds_create_writer(domain(), of, how, NULL);
  dds_delete_qos(how);
  return writer < 0 ? NULL : (void*)(intptr_t)writer;
}

/// Sends 6 numbers under a word.
void sync_send_wrench(void* publisher, const char* word, const double* values) {
  const Wrench message = {.header = {.frame_id = (char*)word},
                          .wrench = {.force = {values[0], values[1], values[2]},
                                     .torque = {values[3], values[4], values[5]}}};
  (void)dds_write((dds_entity_t)(intptr_t)publisher, &message);
}

static void take(dds_entity_t reader, void* act) {
  void* messages[kDepth] = {NULL};
  dds_sample_info_t infos[kDepth];
  const dds_return_t count = dds_take(reader, messages, infos, kDepth, kDepth);
  for (dds_return_t k = 0; k < count; ++k) {
    if (!infos[k].valid_data) continue;
    const Odometry* of = messages[k];
    const geometry_msgs_msg_dds__Pose_ at = of->pose.pose;
    const geometry_msgs_msg_dds__Twist_ by = of->twist.twist;
    const double values[] = {
        (double)of->header.stamp.sec + 1e-9 * of->header.stamp.nanosec,
        at.position.x,
        at.position.y,
        at.position.z,
        at.orientation.w,
        at.orientation.x,
        at.orientation.y,
        at.orientation.z,
        by.linear.x,
        by.linear.y,
        by.linear.z,
        by.angular.x,
        by.angular.y,
        by.angular.z,
    };
    ((Act)act)(values);
  }
  if (count > 0) (void)dds_return_loan(reader, messages, count);
}

/// Calls `act` with time [s], position, rotation w x y z, velocity and rates of each message, in a
/// thread of the library.
bool sync_take_odometry(const char* topic, Act act) {
  dds_qos_t* how = quality();
  dds_listener_t* listener = dds_create_listener((void*)act);
  dds_lset_data_available(listener, take);
  const dds_entity_t of = topic_of(&nav_msgs_msg_dds__Odometry__desc, topic, how);
  const dds_entity_t reader = dds_create_reader(domain(), of, how, listener);
  dds_delete_listener(listener);
  dds_delete_qos(how);
  return reader > 0;
}
