// SPDX-License-Identifier: Apache-2.0
// The MESSAGE_ID of each kind of entry in the journal: all of them, and only here. Each was made
// once with `systemd-id128 new` and never changes its meaning; systemd/mbgate.catalog says for each
// what it means and what to do.
#pragma once

#include <string_view>

namespace mbgate::app {

/// 128 bits in hexadecimal.
struct MessageId {
  std::string_view hex{};
  friend bool operator==(const MessageId&, const MessageId&) = default;
};

namespace message_id {

// Lines, and connections used instead of them.
inline constexpr MessageId kBusOpened{"081eea8ebe034955b7bcb57c36f69d76"};
inline constexpr MessageId kBusLost{"434be031e2434578a61347adda730233"};
inline constexpr MessageId kLineFailure{"39274ab0a2d441109e9d6aa33498fb8f"};
inline constexpr MessageId kLineWarning{"b4edb704280640228ee2a49d034606cd"};
inline constexpr MessageId kAdapterSilent{"ee935428a32a4cc5af368072827bf06a"};
inline constexpr MessageId kConnectionReplaced{"d1a9afd6c4b94c7e824b420c43e87fa0"};
inline constexpr MessageId kLineNeverSilent{"a0dcdafc225f423bab996e6d001735e2"};
inline constexpr MessageId kFramingLost{"8adb1b11479e4ea89c57aa1bc8ed3a3f"};
inline constexpr MessageId kDriverStalled{"70cfc18dc6f54d9ebf0a7f5498485ca3"};
inline constexpr MessageId kEchoDiffered{"531faef7580c4888b07e9358a76d494a"};
inline constexpr MessageId kEchoFound{"02eee58799eb440d9c79994c827685db"};
inline constexpr MessageId kEchoGone{"7f7683dbaec9418cb695b5c9c67df12c"};
inline constexpr MessageId kEchoDenied{"10d9148e376046a494d9a3c9a3f84121"};
inline constexpr MessageId kEchoUnproven{"640e28cc40564f0f8946d7fea71afd15"};
inline constexpr MessageId kAnsweredWhileSending{"8922bba28bcc4013a9a834fbd6c65b11"};

// Devices.
inline constexpr MessageId kDeviceLost{"8a6ee5115b9f4b8899c519c8fd0f4c2e"};
inline constexpr MessageId kDeviceNeverAnswered{"41026f4e2f284e30b2a9156fb07bc700"};
inline constexpr MessageId kDeviceBack{"8e3340ec400e4338824063de7981b51a"};
inline constexpr MessageId kDeviceLate{"b28d474e7f3f4de88dcd1ce3e41ce7e2"};
inline constexpr MessageId kDeviceEarly{"cd32c4469be341cfab55364d6a0a12e1"};
inline constexpr MessageId kForeignRequest{"fc5cf36fca1d4417ad96a89c21783385"};
inline constexpr MessageId kForeignFrame{"95bf41d25fbf4b08a54f6d501c921bca"};
inline constexpr MessageId kMisfit{"18891616610e48fdb85786cd438ab991"};
inline constexpr MessageId kAnswerPauses{"030e7b3b37f44ccf8358cc03bcecb608"};
inline constexpr MessageId kSecondAnswer{"3cbf0d93b48949388e9ed261ca950d27"};
inline constexpr MessageId kStopUnanswered{"530d591ad68743e4b63e604f256002d3"};
inline constexpr MessageId kStopRefused{"e6a6b53579c347f98100fc4a33fa8c2f"};
inline constexpr MessageId kStopForced{"4ea12627b4a349d781420fa6a11914dd"};
inline constexpr MessageId kQualityGood{"538523662d774ed1a8fa8d1f702cfba9"};
inline constexpr MessageId kDeviceBadCrc{"b8c1d7eb9d774b9cb1bf960b717706f7"};
inline constexpr MessageId kLineBadCrc{"f385e8b03f8b46c08920004daa635e95"};
inline constexpr MessageId kNoFrame{"a919aa54e46f4d4b8879989e13ac6d9a"};
inline constexpr MessageId kLateAnswers{"a317349dfc284320a24d25ea3b1c22e1"};
inline constexpr MessageId kReconfigured{"e3d3de4522c4451fbe33bb3d567fdf70"};
inline constexpr MessageId kWriteEndedEarly{"45e510a9c92c4e5aa9b3584b1326ba31"};
inline constexpr MessageId kWordOrderDiffers{"26960d1f31364817908d07e4233064b6"};
inline constexpr MessageId kFailsafeAcknowledged{"b36f1a5ba68e4c2e89173fb0b87a1de8"};
inline constexpr MessageId kFailsafeWaits{"f948cf7c4721498f827405508603084a"};
inline constexpr MessageId kFailsafeClientBack{"f4bce7a03e1841cb82908ed5cf365b3b"};
inline constexpr MessageId kFailsafeGivenUp{"bb6b1e9625184d34ad18218211fafba1"};
inline constexpr MessageId kFailsafeDeviceGone{"437af4673229470bbb1bcbb412b945e1"};

// Clients.
inline constexpr MessageId kClientNotAllowed{"d6d9a8890c064b94a02c15e6d44d6790"};
inline constexpr MessageId kClientNoRoom{"737e12e1b33b4dffa6d1a87b96250fcf"};
inline constexpr MessageId kClientWhileStopping{"80d4525fd4924fa5a537f22298b2b452"};
inline constexpr MessageId kClientAddressFull{"55b29072b0094079951f10d6f4a1566e"};
inline constexpr MessageId kClientTooOften{"c3f63bbef5ab45728efbcf76c3be5cc6"};
inline constexpr MessageId kClientOverRate{"ccb569aa9abf418f9c6124fec2d3e626"};
inline constexpr MessageId kClientDisplaced{"af52e3b3adb24e539419b9700fff4014"};
inline constexpr MessageId kClientFramingLost{"902aa8155c9141c1a6ccdc6f44997388"};
inline constexpr MessageId kClientSpeaksRtu{"2216a36b597145a397ec49f589b12854"};
inline constexpr MessageId kClientFrameTimedOut{"271edbe09ffe4d2e8cdf734f2aa73a88"};
inline constexpr MessageId kTlsRefused{"b09994b755ed4845bd74d6bf8afc7649"};
inline constexpr MessageId kUnitNotRouted{"a61c22f76a8144eea5feafe89de90622"};
inline constexpr MessageId kClientNotRuled{"3ef95af9bd0e4950be05f3620d21fd72"};
inline constexpr MessageId kRequestDenied{"95f5507ea336491e96a948d64fe89b2c"};
inline constexpr MessageId kStopDenied{"51b69766f9324c17a7681457ac59a2b5"};
inline constexpr MessageId kWriteAccepted{"ab1d9f362ddb40b886ff39db96850340"};
inline constexpr MessageId kBroadcastLeavesOut{"a35fa5cce01b4a8cbd74c8569afbbe66"};
inline constexpr MessageId kClientLoggedIn{"3d74485defe64f36946b37ed31700a4c"};

// The process and its configuration.
inline constexpr MessageId kListening{"e4d522ae5037425a8db3b8e5fc337ca8"};
inline constexpr MessageId kListenerRefused{"53874f2bd13940a7b91c61eeb1234dc4"};
inline constexpr MessageId kListenerWaits{"005fb0671cab456f970269cfb7cb55a3"};
inline constexpr MessageId kAcceptFailed{"0831bb01b3e74591881e83e54dd44adf"};
inline constexpr MessageId kSocketUnknown{"a3762e8f7e504f62af08e0eef333c148"};
inline constexpr MessageId kTooFewDescriptors{"29a92fc1bea44e4688d115220d4eead6"};
inline constexpr MessageId kConfigurationWrong{"e0b34442ff8948b1b95cd5120e31c45e"};
inline constexpr MessageId kDenied{"deb6be488d9745fe8c0dcb9fe2efb691"};
inline constexpr MessageId kStartRefused{"f84cef9840a24f8e8ffccb45a536b8c8"};
inline constexpr MessageId kConfigurationKept{"682a9774e7134eaab32c70cb334467b2"};
inline constexpr MessageId kConfigurationChanged{"d215b9b94ba94413b0322aa45a6a9e62"};
inline constexpr MessageId kConfigurationInForce{"1012fa2b62c74254a46df57d948a5219"};
inline constexpr MessageId kConfigurationDigest{"4b15b0ab6eed43c5827bc1e56014abf0"};
inline constexpr MessageId kConfigurationNextStart{"9aa469bf78924912af6a68d864e086cd"};
inline constexpr MessageId kCertificateWrong{"252fe903f1f44d6a84d74075a127b761"};
inline constexpr MessageId kCertificateEnds{"ad923bfe738147598f7109d802abb3fc"};
inline constexpr MessageId kStopping{"cac09ef44bfd49b2b3cd8c05e6b36d5c"};
inline constexpr MessageId kFatal{"059e80f7e8e14b4fa736ae6249c3903c"};
inline constexpr MessageId kRecordingEnded{"c7808491f5f943488c4508ffb2f05b6d"};
inline constexpr MessageId kMemoryNotLocked{"15eca9f07f6f423d931efeb9cdb03dd3"};
inline constexpr MessageId kStalled{"71cadb0d60d7402eb2eecf562be26662"};
inline constexpr MessageId kControlFailed{"cc2aa463d22f47f2ba914f8e111892bb"};
inline constexpr MessageId kHttpRefused{"b80a774d1c884a8395c2ae6e9d5f2d73"};
inline constexpr MessageId kCountersCleared{"883eb32103ba4de6ba74e51b98190935"};
inline constexpr MessageId kReloadAsked{"d868dfa2751746faa58f38f92691e862"};
inline constexpr MessageId kCommandDenied{"957d1e0d7fa14596bb3fbf7b135554a3"};
inline constexpr MessageId kLinesMissing{"45213c7f9594479f8ff69fe7519001e0"};

}  // namespace message_id

}  // namespace mbgate::app
