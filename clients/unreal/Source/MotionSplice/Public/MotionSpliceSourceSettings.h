// The settings of a source in Live Link's details panel. Presets save them.
#pragma once

#include "CoreMinimal.h"
#include "Engine/EngineTypes.h"
#include "LiveLinkSourceSettings.h"
#include "UObject/SoftObjectPath.h" // has FDirectoryPath in newer engines, and EngineTypes.h in older ones
#include "MotionSpliceSourceSettings.generated.h"

/** How the action keeps its posture on the locomotion's hips. */
UENUM()
enum class EMotionSplicePosture : uint8
{
	Off,
	Relative,
	Absolute,
	Running,
};

/** What a source plays. */
USTRUCT()
struct FMotionSplicePlayback
{
	GENERATED_BODY()

	/** Folder of the bank, absolute or relative to the project. */
	UPROPERTY(EditAnywhere, Category = "motionsplice")
	FDirectoryPath Bank;

	/** Clip that gives the root and the lower body. */
	UPROPERTY(EditAnywhere, Category = "motionsplice")
	FString Locomotion = TEXT("walk");

	/** Clip that gives the upper body. Empty: the locomotion's own. */
	UPROPERTY(EditAnywhere, Category = "motionsplice")
	FString Action;

	/** Hands to lay on the clip that gives the upper body. Empty: that clip's own. */
	UPROPERTY(EditAnywhere, Category = "motionsplice")
	FString Hands;

	UPROPERTY(EditAnywhere, Category = "motionsplice")
	EMotionSplicePosture Posture = EMotionSplicePosture::Relative;

	/** Stay at the origin instead of walking away from it. */
	UPROPERTY(EditAnywhere, Category = "motionsplice")
	bool bInPlace = false;

	/** Frames per second. */
	UPROPERTY(EditAnywhere, Category = "motionsplice", meta = (ClampMin = 1, ClampMax = 240))
	double Rate = 60.0;

	/** Name of the Live Link subject. */
	UPROPERTY(EditAnywhere, Category = "motionsplice")
	FName Subject = TEXT("motionsplice");
};

UCLASS()
class MOTIONSPLICE_API UMotionSpliceSourceSettings : public ULiveLinkSourceSettings
{
	GENERATED_BODY()

public:
	UPROPERTY(EditAnywhere, Category = "motionsplice", meta = (ShowOnlyInnerProperties))
	FMotionSplicePlayback Playback;
};
