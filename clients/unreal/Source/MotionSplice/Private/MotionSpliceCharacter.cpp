#include "MotionSpliceCharacter.h"

#include "Misc/FileHelper.h"
#include "Misc/Paths.h"
#include "MotionSpliceSourceSettings.h"

namespace
{
	// motionsplice: right-handed, Y up, Z forward, metres. Unreal: left-handed, Z up, X forward, centimetres.
	FVector ToUnreal(double X, double Y, double Z)
	{
		return FVector(Z, -X, Y) * 100.0;
	}

	FQuat ToUnreal(const float* Xyzw)
	{
		return FQuat(-Xyzw[2], Xyzw[0], -Xyzw[1], Xyzw[3]);
	}

	FString ToString(const std::string& Utf8)
	{
		return FString(UTF8_TO_TCHAR(Utf8.c_str()));
	}

	std::string ToUtf8(const FString& Text)
	{
		return std::string(TCHAR_TO_UTF8(*Text));
	}
}

TUniquePtr<FMotionSpliceCharacter> FMotionSpliceCharacter::Open(const FString& Folder, FString& Error)
{
	const FString Path = FPaths::ConvertRelativePathToFull(FPaths::ProjectDir(), Folder);
	const auto Read = [&Path](const std::string& Name, std::vector<unsigned char>& Bytes)
	{
		TArray<uint8> Found;
		if (!FFileHelper::LoadFileToArray(Found, *(Path / ToString(Name)), FILEREAD_Silent))
		{
			return false;
		}
		Bytes.assign(Found.GetData(), Found.GetData() + Found.Num());
		return true;
	};
	motionsplice::Error Fault;
	motionsplice::Bank Opened = motionsplice::Bank::open(Read, ToUtf8(Path), Fault);
	if (Fault)
	{
		Error = ToString(Fault.message());
		return nullptr;
	}
	return MakeUnique<FMotionSpliceCharacter>(MoveTemp(Opened));
}

FMotionSpliceCharacter::FMotionSpliceCharacter(motionsplice::Bank&& InBank)
	: Bank(MoveTemp(InBank))
	, Evaluator(Bank)
{
	Rotations.SetNum(4 * Bank.joint_count());
}

TArray<FName> FMotionSpliceCharacter::BoneNames() const
{
	TArray<FName> Names;
	for (const std::string& Name : Bank.skeleton().names)
	{
		Names.Add(FName(UTF8_TO_TCHAR(Name.c_str())));
	}
	return Names;
}

TArray<int32> FMotionSpliceCharacter::BoneParents() const
{
	TArray<int32> Parents;
	for (const std::int64_t Parent : Bank.skeleton().parents)
	{
		Parents.Add(static_cast<int32>(Parent));
	}
	return Parents;
}

FString FMotionSpliceCharacter::Play(const FMotionSplicePlayback& Playback)
{
	motionsplice::Splice Next;
	Next.locomotion = Bank.find(ToUtf8(Playback.Locomotion));
	Next.action = Playback.Action.IsEmpty() ? motionsplice::NOTHING : Bank.find(ToUtf8(Playback.Action));
	Next.hands = Playback.Hands.IsEmpty() ? motionsplice::NOTHING : Bank.find_hands(ToUtf8(Playback.Hands));
	Next.posture = static_cast<motionsplice::Posture>(Playback.Posture); // both have the same order
	const FString* Unknown = Next.locomotion == motionsplice::NOT_FOUND ? &Playback.Locomotion
		: Next.action == motionsplice::NOT_FOUND ? &Playback.Action
		: Next.hands == motionsplice::NOT_FOUND ? &Playback.Hands
		: nullptr;
	if (Unknown != nullptr)
	{
		return FString::Printf(TEXT("unknown clip \"%s\". `motionsplice inspect` lists the bank's clips."), **Unknown);
	}
	if (Next.locomotion != Splice.locomotion)
	{
		Time = 0.0;
	}
	else
	{
		Next.cycles = Splice.cycles;
	}
	Splice = Next;
	Memory = motionsplice::Memory::begin(Playback.Rate);
	bInPlace = Playback.bInPlace;
	if (bInPlace)
	{
		Place = motionsplice::Place();
	}
	return FString();
}

void FMotionSpliceCharacter::Advance(double Seconds)
{
	const motionsplice::ClipEntry& Clip = Bank.clip(Splice.locomotion);
	const double Rest = Clip.end() - Time;
	if (Clip.loop == 0 && Seconds > Rest)
	{
		Move(Rest);
		Time = 0.0;
		Seconds -= Rest;
	}
	Move(Seconds);
}

void FMotionSpliceCharacter::Move(double Seconds)
{
	const motionsplice::RootMotion Step = Evaluator.root_motion(Splice.locomotion, Time, Seconds);
	Time = Step.time;
	Splice.cycles += Step.cycles; // keeps the action in step when the locomotion loops
	if (!bInPlace)
	{
		Place.move(Step);
	}
}

FString FMotionSpliceCharacter::Evaluate(TArray<FTransform>& Transforms)
{
	float Root[3];
	if (const motionsplice::Error Fault = Evaluator.pose(Splice, Time, Rotations.GetData(), Root, &Memory))
	{
		return ToString(Fault.message());
	}
	Evaluator.put(Place, Splice.locomotion, Time, Rotations.GetData(), Root);
	Transforms.SetNum(Bank.joint_count());
	for (int32 Bone = 0; Bone < Transforms.Num(); ++Bone)
	{
		const std::array<double, 3>& Offset = Bank.skeleton().offsets[static_cast<std::size_t>(Bone)];
		const FVector Position = Bone == 0 ? ToUnreal(Root[0], Root[1], Root[2]) : ToUnreal(Offset[0], Offset[1], Offset[2]);
		Transforms[Bone] = FTransform(ToUnreal(&Rotations[4 * Bone]), Position);
	}
	return FString();
}
