// Kinds of end points. Others than these two are refused: antEnvCreateEndpointMsg::error says so.
#ifndef SEAM_OPEN_R_ENDPOINT_TYPES_H
#define SEAM_OPEN_R_ENDPOINT_TYPES_H

enum { EndpointType_TCP = 1, EndpointType_UDP = 2, EndpointType_DNS = 4, EndpointType_IP = 7 };

#endif
