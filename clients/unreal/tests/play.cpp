// Runs the plugin with a Live Link client that prints what is pushed: the program of tests/clients/test_unreal.py.
//
//     play BANK < COMMANDS
//
//     set NAME VALUE                            changes a setting, also while the source plays; VALUE may be -
//     character FRAMES                          prints frames of a character with these settings, without threads
//     start                                     creates a source in the factory's way; its bank is BANK if not set
//     wait FRAMES                               returns when so many more frames are pushed
//     until TEXT                                returns when the source's status begins with TEXT; prints the status
//     stop                                      shuts the source down as Live Link does
//     destroy                                   destroys it as it is
//     mesh YAW BONES                            then BONES lines of its reference pose: name parent x y z w x y z scale
//                                               prints where its bones are in the last frame of `character`
//
// Prints a map of JSON in each line.
#include <atomic>
#include <chrono>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <sstream>
#include <thread>

#include "BonePose.h"
#include "ILiveLinkClient.h"
#include "MotionSpliceCharacter.h"
#include "MotionSpliceRetargetAsset.h"
#include "MotionSpliceSource.h"
#include "MotionSpliceSourceFactory.h"
#include "Roles/LiveLinkAnimationTypes.h"

std::u16string Utf16(const std::string& Utf8)
{
	return std::filesystem::path(Utf8).u16string();
}

std::string Utf8(const std::u16string& Utf16)
{
	return std::filesystem::path(Utf16).string();
}

static std::mutex Output;

static std::string Quoted(const FString& Text)
{
	std::string Json = "\"";
	for (const char Character : Utf8(*Text))
	{
		Json += Character == '"' || Character == '\\' ? std::string("\\") + Character : std::string(1, Character);
	}
	return Json + "\"";
}

static void Print(const std::string& Key, const std::string& Json)
{
	const std::lock_guard<std::mutex> Guard(Output);
	std::cout << "{\"" << Key << "\": " << Json << "}" << std::endl;
}

void Log(const FString& Line)
{
	Print("log", Quoted(Line));
}

/** Position, and rotation as x, y, z, w, of each bone. */
static std::string Listed(const TArray<FTransform>& Transforms)
{
	std::ostringstream Json;
	Json.precision(17);
	for (const FTransform& Bone : Transforms)
	{
		const FVector P = Bone.GetTranslation();
		const FQuat Q = Bone.GetRotation();
		Json << (Json.tellp() > 0 ? ", [" : "[") << P.X << ", " << P.Y << ", " << P.Z << ", ";
		Json << Q.X << ", " << Q.Y << ", " << Q.Z << ", " << Q.W << "]";
	}
	return "[" + Json.str() + "]";
}

/** Prints what is pushed. */
class FPrintingClient final : public ILiveLinkClient
{
public:
	std::atomic<int> Frames{0};

	virtual void PushSubjectStaticData_AnyThread(
		const FLiveLinkSubjectKey& Key, TSubclassOf<ULiveLinkRole> Role, FLiveLinkStaticDataStruct&& Data) override
	{
		const FLiveLinkSkeletonStaticData* Bones = Data.Cast<FLiveLinkSkeletonStaticData>();
		if (Role.Get() != ULiveLinkAnimationRole::StaticClass() || Bones == nullptr)
		{
			return Print("fault", "\"not static data of an animation\"");
		}
		std::string Json = Quoted(Key.SubjectName.ToString());
		for (int32 Bone = 0; Bone < Bones->GetBoneNames().Num(); ++Bone)
		{
			Json += ", [" + Quoted(Bones->GetBoneNames()[Bone].ToString());
			Json += ", " + std::to_string(Bones->GetBoneParents()[Bone]) + "]";
		}
		Print("bones", "[" + Json + "]");
	}

	virtual void PushSubjectFrameData_AnyThread(const FLiveLinkSubjectKey& Key, FLiveLinkFrameDataStruct&& Data) override
	{
		const FLiveLinkAnimationFrameData* Frame = Data.Cast<FLiveLinkAnimationFrameData>();
		std::ostringstream Time;
		Time.precision(17);
		Time << Frame->WorldTime.GetOffsettedTime();
		Print("frame", "[" + Quoted(Key.SubjectName.ToString()) + ", " + Time.str() + ", " + Listed(Frame->Transforms) + "]");
		++Frames;
	}

	virtual void RemoveSubject_AnyThread(const FLiveLinkSubjectKey& Key) override
	{
		Print("removed", Quoted(Key.SubjectName.ToString()));
	}
};

/** Reads a word, which has quotes if it contains spaces; "-" stands for an empty one. */
static FString Word()
{
	std::string Text;
	std::cin >> std::quoted(Text);
	return Text == "-" ? FString() : FString(UTF8_TO_TCHAR(Text));
}

template <class T> static T Number()
{
	T Value{};
	std::cin >> Value;
	return Value;
}

static void Set(FMotionSplicePlayback& Playback, const std::string& Name)
{
	if (Name == "bank") Playback.Bank.Path = Word();
	if (Name == "locomotion") Playback.Locomotion = Word();
	if (Name == "action") Playback.Action = Word();
	if (Name == "hands") Playback.Hands = Word();
	if (Name == "posture") Playback.Posture = static_cast<EMotionSplicePosture>(Number<int>());
	if (Name == "in_place") Playback.bInPlace = Number<int>() != 0;
	if (Name == "rate") Playback.Rate = Number<double>();
	if (Name == "subject") Playback.Subject = FName(*Word());
}

static TArray<FTransform> Character(const FMotionSplicePlayback& Playback, FLiveLinkSkeletonStaticData& Bones)
{
	FString Error;
	TArray<FTransform> Transforms;
	const TUniquePtr<FMotionSpliceCharacter> Played = FMotionSpliceCharacter::Open(Playback.Bank.Path, Error);
	if (Played) Error = Played->Play(Playback);
	for (int Frames = Number<int>(); Error.IsEmpty() && Frames > 0; --Frames)
	{
		Error = Played->Evaluate(Transforms);
		Print("frame", Listed(Transforms));
		Played->Advance(1.0 / Playback.Rate);
	}
	if (!Error.IsEmpty()) Print("fault", Quoted(Error));
	if (Played) Bones.SetBoneNames(Played->BoneNames());
	return Transforms;
}

static void Mesh(const FLiveLinkSkeletonStaticData& Bones, const TArray<FTransform>& Transforms)
{
	UMotionSpliceRetargetAsset Asset;
	Asset.MeshYaw = Number<double>();
	FBoneContainer Container;
	for (int Count = Number<int>(); Count > 0; --Count)
	{
		double V[8];
		Container.Names.Add(FName(*Word()));
		Container.Parents.Add(Number<int>());
		for (double& Value : V) std::cin >> Value;
		const FQuat Rotation(V[0], V[1], V[2], V[3]);
		Container.RefPose.Add(FTransform(Rotation, FVector(V[4], V[5], V[6]), FVector(V[7], V[7], V[7])));
	}
	FCompactPose Pose(Container);
	FLiveLinkAnimationFrameData Frame;
	Frame.Transforms = Transforms;
	Asset.BuildPoseFromAnimationData(0.0f, &Bones, &Frame, Pose);
	TArray<FTransform> World;
	for (const FCompactPoseBoneIndex Bone : Pose.ForEachBoneIndex())
	{
		const int32 Parent = Pose.GetParentBoneIndex(Bone).GetInt();
		World.Add(Parent == INDEX_NONE ? Pose[Bone] : Pose[Bone] * World[Parent]);
	}
	Print("mesh", Listed(World));
}

int main(int Count, char** Arguments)
{
	if (Count != 2) return 2;
	FPrintingClient Client;
	UMotionSpliceSourceSettings Settings;
	Settings.Playback.Bank.Path = FString(UTF8_TO_TCHAR(std::string(Arguments[1])));
	TSharedPtr<ILiveLinkSource> Source;
	FLiveLinkSkeletonStaticData Bones;
	TArray<FTransform> Transforms;
	const auto Until = [](const auto& Condition)
	{
		for (int Tries = 0; !Condition(); ++Tries)
		{
			if (Tries > 20000) return Print("fault", "\"20 seconds passed\"");
			std::this_thread::sleep_for(std::chrono::milliseconds(1));
		}
	};
	for (std::string Command; std::cin >> Command;)
	{
		if (Command == "character") Transforms = Character(Settings.Playback, Bones);
		if (Command == "mesh") Mesh(Bones, Transforms);
		if (Command == "set")
		{
			std::string Name;
			std::cin >> Name;
			Print("before", Quoted(FString(UTF8_TO_TCHAR(Name))));
			Set(Settings.Playback, Name);
			if (Source) Source->OnSettingsChanged(&Settings, FPropertyChangedEvent());
			Print("after", Quoted(FString(UTF8_TO_TCHAR(Name))));
		}
		if (Command == "start")
		{
			const UMotionSpliceSourceFactory Factory;
			Source = Factory.CreateSource(FString());
			if (Source->GetSettingsClass().Get() != UMotionSpliceSourceSettings::StaticClass()) return 3;
			if (Factory.GetMenuType() != ULiveLinkSourceFactory::EMenuType::MenuEntry) return 4;
			Source->ReceiveClient(&Client, FGuid());
			Source->InitializeSettings(&Settings);
		}
		if (Command == "wait")
		{
			const int Enough = Client.Frames + Number<int>();
			Until([&] { return Client.Frames >= Enough; });
		}
		if (Command == "until")
		{
			const std::string Begin = Utf8(*Word());
			Until([&] { return Utf8(*Source->GetSourceStatus().ToString()).rfind(Begin, 0) == 0; });
			Print("status", Quoted(Source->GetSourceStatus().ToString()));
			Print("valid", Source->IsSourceStillValid() ? "true" : "false");
		}
		if (Command == "stop") Until([&] { return Source->RequestSourceShutdown(); });
		if (Command == "stop" || Command == "destroy") Source.Reset();
	}
	return 0;
}
